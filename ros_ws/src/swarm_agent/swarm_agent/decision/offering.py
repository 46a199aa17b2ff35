"""Which cost row a robot offers, and when.

A robot offers its costs once per plan, and anew when a robot of its type joins and it has moved since. That is enough:
who follows a shortest path to its goal makes that goal cheaper by every meter driven, and no other goal by more. So an
assignment that was best stays best in any mixture of old and fresh rows, and late rows flip nobody's goal.

A robot that takes no part offers no costs. Its row keeps the goal that it had: that one costs what it did, the others
cannot be reached. What is best for the rest of the robots and goals is then what it was before, so nobody else changes.
Who has no goal to keep, or keeps one that another robot could use, offers an empty row.

For the longest path (`Objective.BOTTLENECK`) remaining paths would not do: in a mixture of rows the longest one depends
on who has spoken last. There a fresh row tells whole paths, what the robot has driven towards its goal included. The
own goal then costs what it cost before, and no other goal less; so again, no mixture of rows moves anybody.

Goals may move, and rows of different times would then speak of different places: two robots that go along with theirs
could be given each other's. So all rows under one set of goal ids speak of where the goals were when those ids were
given. A robot stands, for its row, where it would have stood then: as far from its goal as it is now, in the same
direction. What it says is then what it would say if nothing moved, and the argument above holds. Without a goal, the
nearest one counts. Who hears of such goals late, or anew after a restart, knows where they were at the beginning of the
motion of the first plan that it hears; after several motions that is not the same, but the nearest it can get.

Path lengths count by the robot's weight, which it decides once per plan: else what has been said of the own goal would
not hold.
"""

from __future__ import annotations

from enum import Enum, auto

import numpy as np

from swarm_agent.decision.config import DecisionConfig, WeightConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.path_costs import PathCosts, dearer
from swarm_agent.energy import EnergyStore
from swarm_msgs_py.messages.bodies import UNREACHABLE, WEIGHT_MAX, WEIGHT_ONE, Objective, Plan
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.types import FloatArray, IntArray, NodeId


class Row(Enum):
    """Kinds of cost rows."""

    COSTS = auto()
    RESERVATION = auto()
    EMPTY = auto()


class RowOffers:
    """Offers the cost rows of one robot.

    Parameters
    ----------
    robot : NodeId
        Who offers.
    config : DecisionConfig
    paths : PathCosts
        Of its type.
    energy : EnergyStore
        What the robot has left.
    mesh : Network
        The robot's radio network, which carries the rows.
    consensus : Consensus
        The robot's copy of plan and rows.
    period_s : float
        Control period [s].
    """

    def __init__(  # noqa: PLR0913 - collaborators, each named at the one place of construction
        self,
        robot: NodeId,
        *,
        config: DecisionConfig,
        paths: PathCosts,
        energy: EnergyStore,
        mesh: Network,
        consensus: Consensus,
        period_s: float,
    ) -> None:
        self._robot = robot
        self._config = config
        self._paths = paths
        self._energy = energy
        self._mesh = mesh
        self._consensus = consensus
        self._pause = max(1, round(config.refresh_pause_s / period_s))
        self._spread = max(1, round(config.refresh_spread_s / period_s))
        self._since = 0  # epoch with which the rows began
        self._origins = np.empty((0, 2))  # of the goals of the type, which rows speak of [m]
        self._weight = WEIGHT_ONE  # for this plan
        self._lengths: IntArray | None = None  # of the paths [steps], as the last row was made from them
        self._driven = 0  # of the path to the goal, under this plan [steps]
        self._kind: Row | None = None
        self._version = 0  # of the row offered last
        self._offered_at = 0  # tick
        self._offered_from: FloatArray | None = None
        self._members: frozenset[NodeId] = frozenset()
        self._members_at: int | None = None  # digest of the rows that the members were read from
        self._is_stale = False  # others have joined, and the last row is from elsewhere
        self._is_surcharged = False  # the last row says more than path lengths

    def step(self, tick: int, plan: Plan, position: FloatArray, goal: int, *, takes_part: bool) -> None:
        """Offer a row if one is due.

        Parameters
        ----------
        tick : int
        plan : Plan
            In force.
        position : (2,) array
            Own estimate [m].
        goal : int
            Goal id that the robot has now, -1 for none.
        takes_part : bool
            Whether the robot is there for a goal.
        """
        since = self._consensus.book.since
        if since != self._since:
            self._weight = weight_of(self._config.weight, self._energy.left)
            self._lengths, self._driven = None, 0
            self._since, self._kind, self._version = since, None, 0
            self._origins = self._paths.origins(plan)
            self._members, self._members_at, self._is_stale = frozenset(), None, False
        self._watch_members(tick, plan, position, goal)
        kind = self._due(tick, plan, goal, takes_part=takes_part)
        if kind is not None:
            place = self._place(tick, plan, position, goal)
            self._offer(tick, place, self._row(plan, place, goal, kind), kind)

    def offer_swap(self, tick: int, plan: Plan, position: FloatArray, goal: int, surcharge: IntArray) -> None:
        """Offer costs that are higher by a surcharge for each goal, (m,) [steps]; none keeps the own goal."""
        place = self._place(tick, plan, position, goal)
        self._offer(tick, place, self._row(plan, place, goal, Row.COSTS, surcharge), Row.COSTS)
        self._is_surcharged = True

    def _place(self, tick: int, plan: Plan, position: FloatArray, goal: int) -> FloatArray:
        """Return where the robot would stand if the goals were where rows speak of, (2,) [m]."""
        goals = self._paths.places(tick, plan)
        if not len(goals):
            return position
        own = np.flatnonzero(self._paths.goals(plan) == goal)
        anchor = int(own[0]) if len(own) else int(np.argmin(np.linalg.norm(goals - position, axis=1)))
        place: FloatArray = position + (self._origins[anchor] - goals[anchor])
        return place

    def _watch_members(self, tick: int, plan: Plan, position: FloatArray, goal: int) -> None:
        """Note robots that join: costs from another place than the present one would misjudge what to give them."""
        book = self._consensus.book
        if book.digest == self._members_at:
            return
        members = frozenset(row.robot for row in book.of_type(self._paths.robot_type))
        joined = members - self._members - {self._robot}
        self._members, self._members_at = members, book.digest
        if joined and self._offered_from is not None and self._kind is not None:
            moved = float(np.hypot(*(self._place(tick, plan, position, goal) - self._offered_from)))
            self._is_stale = self._is_stale or self._is_surcharged or moved >= self._config.refresh_distance_m

    def _due(self, tick: int, plan: Plan, goal: int, *, takes_part: bool) -> Row | None:
        """Return the kind of row to offer now, None if the last one is good."""
        book = self._consensus.book
        if not takes_part:
            is_needed = book.answered(self._paths.robot_type) > len(self._paths.goals(plan))
            wanted = Row.RESERVATION if goal >= 0 and not is_needed else Row.EMPTY
            # Once given up, a goal is not taken back: it may be on its way to another robot.
            is_good = self._kind in {wanted, Row.EMPTY}
            return None if is_good and self._is_known() else (Row.EMPTY if self._kind is Row.EMPTY else wanted)
        if self._kind in {None, Row.EMPTY} or not self._is_known() or (self._kind is Row.RESERVATION and goal < 0):
            return Row.COSTS
        is_turn = (tick + self._robot) % self._spread == 0 and tick - self._offered_at >= self._pause
        return Row.COSTS if self._is_stale and is_turn else None

    def _is_known(self) -> bool:
        """Return whether others can only hold the last row offered, not one of an earlier life of this robot."""
        consensus = self._consensus
        return not consensus.is_contested and consensus.book.version_of(self._robot) == self._version

    def _offer(self, tick: int, place: FloatArray, row: IntArray, kind: Row) -> None:
        self._consensus.offer(tick, row, self._mesh, self._weight)
        self._kind, self._version = kind, self._consensus.book.version_of(self._robot)
        self._offered_at, self._offered_from = tick, place.copy()
        self._is_stale = self._is_surcharged = False

    def _row(self, plan: Plan, place: FloatArray, goal: int, kind: Row, surcharge: IntArray | None = None) -> IntArray:
        """Return the costs of the goals of the own type [steps], (m,), from a `_place`; (0,) for an empty row."""
        if kind is Row.EMPTY:
            return np.empty(0, dtype=np.int64)
        is_own = self._paths.goals(plan) == goal
        if kind is Row.RESERVATION:
            return np.where(is_own, 0 if self._lengths is None else self._lengths, UNREACHABLE)
        lengths = self._paths.to(self._origins, plan, place)
        keep, discount = self._paths.steps(self._config.keep_goal_m), 0
        if self._config.objective is Objective.BOTTLENECK:
            lengths = self._whole(lengths, is_own)
            discount = keep if is_own.any() else 0  # the own goal must not become cheaper: the longest path may be it
        self._lengths = lengths
        return dearer(lengths, discount - keep * is_own if surcharge is None else surcharge)

    def _whole(self, lengths: IntArray, is_own: IntArray) -> IntArray:
        """Return the lengths of whole paths [steps]: what has been driven towards the own goal, and what is left."""
        if self._lengths is not None and is_own.any():
            before, now = int(self._lengths[is_own][0]), int(lengths[is_own][0])
            if UNREACHABLE not in {before, now}:
                self._driven = max(self._driven, before - now)
        return dearer(lengths, self._driven)


def weight_of(config: WeightConfig, energy: float) -> int:
    """Return how much a meter counts of a robot with this share of its energy left, in 1 / `WEIGHT_ONE`."""
    weight = config.priority * (1.0 + config.energy_gain * (1.0 - energy))
    return min(max(round(weight * WEIGHT_ONE), 1), WEIGHT_MAX)
