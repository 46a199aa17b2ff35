"""The cost rows that a robot holds for the plan in force, and their fingerprint."""

from __future__ import annotations

import zlib
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from swarm_msgs_py.body_codec import encode_body
from swarm_msgs_py.messages.bodies import VERSION_LEAP_MAX, WEIGHT_ONE, CostRow, Plan, Task, is_newer_epoch
from swarm_msgs_py.plan_course import lineage
from swarm_msgs_py.plan_goals import is_contour
from swarm_msgs_py.types import NodeId

EARLY_MAX = 1000
"""Rows kept of plans that have not arrived yet, the first ones kept."""

ROWS_MAX = 10_000
"""Robots whose rows are kept, the first ones: more than any roster has, and few enough to list them in one request."""


class RowBook:
    """Newest cost row of every robot, for one epoch.

    A replicated set that only grows: rows merge by highest version, so robots that have exchanged everything hold the
    same book whatever the order of arrival. A robot that has restarted may send another row under a number that it has
    used before; of two such rows the one with the greater checksum counts, for everybody. Rows that come before their
    plan count as soon as it is there: a packet is delivered once, and short ones overtake long ones.

    A plan may follow another one: its goals are those of the other one, which move on. Then the rows stay what they
    were, under the new number, and nobody has to offer anything again.

    Attributes
    ----------
    plan : Plan or None
        The newest plan heard.
    digest : int
        Fingerprint of the rows, of all that they say.
    since : int
        Epoch of the plan with which the rows began that are held now; 0 for none.
    """

    def __init__(self) -> None:
        self.plan: Plan | None = None
        self.digest = 0
        self.since = 0
        self._rows: dict[NodeId, CostRow] = {}
        self._checksums: dict[NodeId, int] = {}  # of these rows
        self._early: dict[NodeId, CostRow] = {}  # of the newest plan of which a row of that robot was heard

    @property
    def epoch(self) -> int:
        """Epoch of the plan held, 0 for none."""
        return self.plan.epoch if self.plan is not None else 0

    def is_news(self, plan: Plan) -> bool:
        """Return whether a plan is newer than the one held, and not absurd."""
        return is_newer_epoch(plan.epoch, self.epoch) and _is_sound(plan)

    def adopt(self, plan: Plan) -> bool:
        """Take a newer plan; return whether it was news. The old rows are forgotten unless the plan follows theirs."""
        if not self.is_news(plan):
            return False
        if self.plan is not None and _have_the_same_goals(self.plan, plan):
            self._rows = {robot: replace(row, epoch=plan.epoch) for robot, row in self._rows.items()}
        else:
            self._rows, self._checksums, self.digest, self.since = {}, {}, 0, plan.epoch
        self.plan = plan
        early, self._early = self._early, {}
        for row in early.values():
            self.put(row)
        return True

    def put(self, row: CostRow) -> bool:
        """Take a row of this epoch if it is newer than the one held; return whether it was (and not absurd)."""
        if self.plan is not None and lineage(self.plan) <= row.epoch < self.epoch:
            row = replace(row, epoch=self.epoch)  # of a plan that this one follows
        if row.epoch != self.epoch:
            self._keep_early(row)
            return False
        version = self.version_of(row.robot)
        if not version <= row.version <= version + VERSION_LEAP_MAX or not self._fits(row):
            return False
        if version == 0 and (row.version == 0 or len(self._rows) >= ROWS_MAX):
            return False
        new, old = checksum(row), self._checksums.get(row.robot, 0)
        if row.version == version and new <= old:
            return False
        self._rows[row.robot], self._checksums[row.robot] = row, new
        # Order-free sum of one checksum per row: merging in any order ends at the same digest.
        self.digest = (self.digest + new - old) % 2**32
        return True

    def versions(self) -> tuple[tuple[NodeId, int], ...]:
        """Return robot and version of every row held, ascending."""
        return tuple((robot, self._rows[robot].version) for robot in sorted(self._rows))

    def missing_in(self, held: Iterable[tuple[NodeId, int]]) -> tuple[CostRow, ...]:
        """Return the rows that somebody who holds `held` lacks, ascending by robot."""
        theirs = dict(held)
        return tuple(self._rows[r] for r in sorted(self._rows) if self._rows[r].version > theirs.get(r, 0))

    @property
    def offers(self) -> tuple[CostRow, ...]:
        """All rows, ascending by robot; withdrawn (empty) ones are left out."""
        return tuple(row for _, row in sorted(self._rows.items()) if len(row.costs))

    def of_type(self, robot_type: int) -> tuple[CostRow, ...]:
        """Return the rows of one type of robot, ascending by robot; withdrawn (empty) rows are left out."""
        return tuple(row for row in self.offers if row.robot_type == robot_type)

    def answered(self, robot_type: int) -> int:
        """Return how many robots of one type have sent a row, withdrawn ones included."""
        return sum(row.robot_type == robot_type for row in self._rows.values())

    def is_complete(self, robot_types: Iterable[int]) -> bool:
        """Return whether as many robots of each of these types have sent a row as the plan has goals for them."""
        if self.plan is None:
            return False
        kinds = self.plan.goal_types
        return all(self.answered(kind) >= int((kinds == kind).sum()) for kind in robot_types)

    def version_of(self, robot: NodeId) -> int:
        """Return the version of a robot's row, 0 for none."""
        row = self._rows.get(robot)
        return row.version if row else 0

    def all_rows(self) -> tuple[CostRow, ...]:
        """Return every row held, ascending by robot."""
        return tuple(self._rows[robot] for robot in sorted(self._rows))

    def weight_of(self, robot: NodeId) -> int:
        """Return what a robot's row says of its weight, that of an ordinary robot if it has sent none."""
        row = self._rows.get(robot)
        return row.weight if row else WEIGHT_ONE

    def __len__(self) -> int:
        return len(self._rows)

    def _keep_early(self, row: CostRow) -> None:
        """Keep a row of a newer plan until that comes."""
        kept = self._early.get(row.robot)
        if not is_newer_epoch(row.epoch, self.epoch) or (kept is None and len(self._early) >= EARLY_MAX):
            return
        if kept is None or _order(kept) < _order(row):
            self._early[row.robot] = row

    def _fits(self, row: CostRow) -> bool:
        """Return whether the row is as long as its type has goals: anything else would break the assignment."""
        if self.plan is None:
            return False
        return len(row.costs) in (0, int((self.plan.goal_types == row.robot_type).sum()))


def _have_the_same_goals(held: Plan, plan: Plan) -> bool:
    """Return whether the goals of a newer plan are, by id, those of the one held, which move on."""
    return lineage(held) == lineage(plan) and np.array_equal(held.goal_types, plan.goal_types)


def _is_sound(plan: Plan) -> bool:
    """Return whether a plan is one that a robot can follow: somewhere to go, and no obstacle without a corner."""
    has_place = len(plan.goals) > 0 if plan.task is Task.GOALS else is_contour(plan.contour)
    return has_place and all(map(len, plan.obstacles))


def checksum(row: CostRow) -> int:
    """Return a checksum of what a row says, whichever of the plans with the same goals it was sent under."""
    return zlib.crc32(encode_body(replace(row, epoch=0)))


def _order(row: CostRow) -> tuple[int, int, int]:
    return row.epoch, row.version, checksum(row)
