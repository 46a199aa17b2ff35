"""Who belongs to the swarm: robots that were heard, and those of them that have been silent for too long."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, replace

from mission_computer.config import MissionConfig
from swarm_msgs_py.messages.bodies import Report
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray, NodeId, robot_name

SIGMA_MAX = 1.0  # [m]; a robot less certain than this of where it is says nothing of use about where its body stands
HELLO_GAP_S = 1.0  # [s]; the hello that a neighbor misses last, and what it takes to stop
NAMED_MAX = 4  # robots that a one-line notice names


@dataclass(frozen=True, slots=True)
class Member:
    """What is known of one robot that has been heard.

    Attributes
    ----------
    robot : NodeId
    type : int
        Type number.
    position : (x, y) or None
        Where it last said it was [m]; None if it did not know well enough to say anything of use.
    epoch, goal : int
        The goal that it last reported, -1 for none, and the plan which that goal belongs to.
    heard_at : float
        When it was last heard, or the mesh last had a route to it [s].
    ahead : (x, y) or None
        The farthest that it may have got after it last said where it was [m]; None if it was at rest, or nothing is
        known of its way. Who is lost has not driven on, but it may have died on the way.
    sigma : float
        Standard deviation of that position [m].
    """

    robot: NodeId
    type: int
    position: tuple[float, float] | None
    epoch: int
    goal: int
    heard_at: float
    ahead: tuple[float, float] | None = None
    sigma: float = 0.0


class Membership:
    """A timeout failure detector over everything that reaches the mission computer.

    A robot is *expected* until it is first heard, then *present*, and *lost* after a silence of `lost_after_s` in which
    the mesh had no route to it either. A lost robot that is heard again is present at once. Silence proves nothing: a
    lost robot may be alive beyond the reach of the mesh, so what is done about a loss is undone on its return.

    Parameters
    ----------
    config : MissionConfig
        How long a silence is a loss, and how often the swarm may be regrouped.
    types : collection of int
        Type numbers of the roster; who claims another one is no member.
    """

    def __init__(self, config: MissionConfig, types: Collection[int]) -> None:
        self._config = config
        self._types = frozenset(types)
        self._members: dict[NodeId, Member] = {}
        self._accounted: frozenset[NodeId] = frozenset()  # the lost robots that the plan in force allows for
        self._accounted_at = -float("inf")
        self._seen: frozenset[NodeId] = frozenset()
        self._seen_since = 0.0

    @property
    def accounted(self) -> frozenset[NodeId]:
        """The lost robots at the last `account`."""
        return self._accounted

    def take_report(self, report: Report, time: float, destination: FloatArray | None = None) -> None:
        """Note what a robot reported, at `time` [s], and where its goal is [m], if that is known."""
        if report.robot_type not in self._types:
            return
        position, ahead = None, None
        if report.sigma <= SIGMA_MAX:
            position = report.position
            if destination is not None and report.mode != Mode.PARKED:
                ahead = _toward(position, destination, self._config.body_drift_m)
        self._members[report.robot] = Member(
            report.robot, report.robot_type, position, report.epoch, report.goal, time, ahead, report.sigma
        )

    def take_presence(self, robot: NodeId, presence: Presence, time: float) -> None:
        """Note what the hello of a direct neighbor says of it."""
        if presence.robot_type not in self._types:
            return
        known = self._members.get(robot)
        position, ahead = None, None
        if presence.sigma <= SIGMA_MAX:
            x, y, vx, vy = presence.belief[:4].tolist()
            position = x, y
            ahead = None if presence.mode == Mode.PARKED else (x + HELLO_GAP_S * vx, y + HELLO_GAP_S * vy)
        epoch, goal = (known.epoch, known.goal) if known else (0, -1)
        self._members[robot] = Member(robot, presence.robot_type, position, epoch, goal, time, ahead, presence.sigma)

    def take_routes(self, reachable: Iterable[NodeId], time: float) -> None:
        """Note to whom there is a route. Who has not spoken yet stays expected: its type is not known."""
        for robot in reachable:
            if robot in self._members:
                self._members[robot] = replace(self._members[robot], heard_at=time)

    def lost(self, time: float) -> tuple[Member, ...]:
        """Return the robots that are lost at `time` [s], ascending."""
        limit = time - self._config.lost_after_s
        return tuple(self._members[robot] for robot in sorted(self._members) if self._members[robot].heard_at <= limit)

    def present(self, time: float) -> tuple[NodeId, ...]:
        """Return the robots that were heard once and are not lost at `time` [s], ascending."""
        limit = time - self._config.lost_after_s
        return tuple(robot for robot in sorted(self._members) if self._members[robot].heard_at > limit)

    def members(self, time: float) -> tuple[Member, ...]:
        """Return what is known of those who are present at `time` [s], ascending."""
        return tuple(self._members[robot] for robot in self.present(time))

    def is_regrouping_due(self, time: float) -> bool:
        """Return whether the lost robots are others than those accounted for, and it is time to act on it.

        Losses that follow each other closely are acted on together; two regroupings are some time apart.
        """
        lost = frozenset(member.robot for member in self.lost(time))
        if lost != self._seen:
            self._seen, self._seen_since = lost, time
        return (
            lost != self._accounted
            and time - self._seen_since >= self._config.regroup_wait_s
            and time - self._accounted_at >= self._config.regroup_pause_s
        )

    def account(self, time: float) -> None:
        """Note that who is lost at `time` [s] has been allowed for, as well as it could be."""
        self._accounted = frozenset(member.robot for member in self.lost(time))
        self._accounted_at = time


def _toward(position: tuple[float, float], destination: FloatArray, reach: float) -> tuple[float, float]:
    """Return the point `reach` [m] from a position on the beeline to a destination, or the destination if nearer."""
    x, y = position
    dx, dy = (float(part) for part in destination - position)
    share = min(1.0, reach / max(math.hypot(dx, dy), 1e-9))
    return x + share * dx, y + share * dy


def change_line(lost: Collection[NodeId], accounted: Collection[NodeId]) -> str:
    """Return who is lost that was not, and who is back, e.g. "r03 and r07 are lost, r05 is back"."""
    gone, back = sorted(set(lost) - set(accounted)), sorted(set(accounted) - set(lost))
    clauses = [
        f"{_names(robots)} {'is' if len(robots) == 1 else 'are'} {state}"
        for robots, state in ((gone, "lost"), (back, "back"))
        if robots
    ]
    return ", ".join(clauses)


def _names(robots: list[NodeId]) -> str:
    names = [robot_name(robot) for robot in robots]
    if len(names) > NAMED_MAX:
        names = [*names[: NAMED_MAX - 1], f"{len(names) - NAMED_MAX + 1} more"]
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
