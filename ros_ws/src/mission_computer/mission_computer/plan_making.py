"""Plans for the shape in force: for the whole roster at first, and for those who are left after losses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from mission_computer.membership import Member
from mission_computer.move import Move
from mission_computer.nearest_types import distance_to_go, nearest_types
from mission_computer.shape import check_inside, load_shape
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.morphing import Morph, morph_between
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.partition import GoalSet, PartitionConfig, adapt, partition
from swarm_msgs_py.partition.domain import check_obstacles
from swarm_msgs_py.partition.moving import knots_for, track
from swarm_msgs_py.plan_goals import completed, goals_crc, is_contour
from swarm_msgs_py.plan_motion import goals_at, outline_at
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

CORNERS = 8  # of the polygon around a lost robot's body
SIGMAS, DOUBT_MAX_M = 2.0, 1.0  # a body may be so far from where it believed to be; more would block too much
SHARES = np.linspace(0.0, 1.0, 25)  # of the time of a motion, at which the way of the shape is looked at
ROUNDING_M = 0.0071  # half the diagonal of a centimeter: so far may a corner be moved when a plan is encoded


@dataclass(frozen=True, slots=True, eq=False)
class _Made:
    """What is remembered of a plan: the row of each goal in `PlanMaker._full`, and the robots that were lost then."""

    rows: IntArray
    lost: frozenset[NodeId]


class PlanMaker:
    """Makes plans, and remembers the goals of the shape in force, so that plans for fewer robots keep most of them.

    Plans that leave the goals to the robots, or have none, follow from the shape and from who is lost alone.

    Parameters
    ----------
    config : PartitionConfig
    roster : Roster
        The robots that a shape is to be filled with.
    obstacles : tuple of (m, 2) array
        Polygons of the map [m].
    bounds : tuple of float or None
        Least x, least y, greatest x, greatest y of the arena [m]; None: no limits.
    task : Task
        What the plans ask of the robots.
    """

    def __init__(
        self,
        config: PartitionConfig,
        roster: Roster,
        obstacles: tuple[FloatArray, ...],
        bounds: tuple[float, float, float, float] | None,
        task: Task = Task.GOALS,
    ) -> None:
        self._config = config
        self._task = task
        self._roster = roster
        self._obstacles = obstacles
        self._bounds = bounds
        self._contour = np.empty((0, 2))
        self._full = GoalSet(np.empty((0, 2)), np.empty(0, dtype=np.int64))
        self._made: dict[int, _Made] = {}  # per epoch, the plans for the shape in force

    def for_shape(self, epoch: int, shape: FloatArray, lost: Sequence[Member], near: Sequence[Member] = ()) -> Plan:
        """Return the first plan for a shape, computed on the numbers that the robots will see.

        Parameters
        ----------
        epoch : int
        shape : (k, 2) array
            [m].
        lost : sequence of Member
        near : sequence of Member
            Robots for whose types the goals are to be where that makes their ways short; none: as the method has it.

        Raises
        ------
        ShapeError
            If the shape cannot be used.
        ConfigError
            If no robot is left.
        FrameError
            If the plan cannot be put into a packet.
        """
        contour = self._sound(shape)
        if self._task is not Task.GOALS:
            plan = self._without_goals(epoch, contour, lost)
            self._contour = contour
            return plan
        roster = self._roster.without(member.type for member in lost)
        goals = partition(contour, roster, self._obstacles, self._config, keep_outs=self._bodies(lost))
        goals = self._nearer(goals, contour, roster, lost, near)
        plan = self._plan(epoch, contour, goals, lost)
        self._contour, self._full = contour, goals
        self._made = {epoch: _Made(np.arange(len(goals.types)), _robots(lost))}
        return plan

    def for_members(self, epoch: int, lost: Sequence[Member]) -> Plan:
        """Return a plan for the shape in force and the robots that are not lost.

        It is thinned out from the shape's first goals, so it depends on who is lost, not on the order of losses; when
        all are back, the first goals are in force again. Goals stay where they are unless a lost robot's body is there.

        Raises
        ------
        ShapeError
            If what the bodies leave free is too small.
        ConfigError
            If no robot is left.
        FrameError
            If the plan cannot be put into a packet.
        """
        if self._task is not Task.GOALS:
            return self._without_goals(epoch, self._contour, lost)
        roster = self._roster.without(member.type for member in lost)
        rows = self._kept_rows(self._full, np.arange(len(self._full.types)), roster, lost)
        bodies = self._bodies(lost)
        goals = self._thinned(self._full, rows, self._contour, roster, lost)
        if goals is None:
            goals = partition(self._contour, roster, self._obstacles, self._config, keep_outs=bodies)
            plan = self._plan(epoch, self._contour, goals, lost)
            self._full, self._made = goals, {epoch: _Made(np.arange(roster.size), _robots(lost))}
            return plan
        plan = self._plan(epoch, self._contour, goals, lost)
        self._made[epoch] = _Made(rows, _robots(lost))
        return plan

    def for_move(self, epoch: int, move: Move, present: Plan, lost: Sequence[Member]) -> Plan:
        """Return a plan whose shape moves, from where that of the present plan will be, as the robots will see it.

        Robots keep their goals, which move along, as long as it is the same robots that have them; else goals are left
        out, or all are found anew, and the robots share them out again.

        Parameters
        ----------
        epoch : int
        move : Move
        present : Plan
            That says where the shape is when the motion begins.
        lost : sequence of Member

        Raises
        ------
        ShapeError
            If the shape cannot be used, or cannot get there: its contour crosses itself on the way, leaves the arena or
            passes over an obstacle, or the method knows no moving shapes.
        ConfigError
            If no robot is left.
        FrameError
            If the plan cannot be put into a packet.
        """
        contour, start = self._sound(move.target), outline_at(present, move.begins)
        morph = morph_between(start, contour, move.rotation_rad)
        self._check_way(morph)
        bodies, roster = self._bodies(lost), self._roster.without(member.type for member in lost)
        knots, nowhere = knots_for(move.duration_s), np.empty((0, 0, 2))
        motion = Motion(move.begins, move.ticks, start, move.rotation_rad, nowhere, knots)
        goals, follows = GoalSet(np.empty((0, 2)), np.empty(0, dtype=np.int64)), 0
        if self._task.has_goals:
            goals, follows = self._beginning(present, move, start, roster, lost)
            motion = replace(motion, track=goals.positions[None])
        if self._task is Task.GOALS:
            places = track(morph, goals, roster, self._obstacles + bodies, self._config, knots=knots)
            goals, motion = GoalSet(places[-1], goals.types), replace(motion, track=places)
        plan = Plan(
            epoch,
            contour,
            self._obstacles + bodies,
            goals.positions,
            goals.types,
            len(bodies),
            self._task,
            roster=roster if self._task is not Task.GOALS else None,
            method=self._config.method if self._task is Task.PARTITION else None,
            motion=motion,
            follows=follows,
        )
        held = self.as_held(encode_body(plan))
        if self._task is Task.PARTITION:
            held = replace(held, goals_crc=goals_crc(held.goals, held.goal_types))
            encode_body(held)
        self._contour, self._full = contour, GoalSet(held.goals, held.goal_types)
        # Plans that follow each other mean the same goals by the same ids.
        same = [number for number in self._made if 0 < follows <= number]
        self._made = dict.fromkeys([*same, epoch], _Made(np.arange(len(held.goals)), _robots(lost)))
        return held

    def renumbered(self, plan: Plan, epoch: int) -> Plan:
        """Return the same plan under another number."""
        if plan.epoch in self._made:
            self._made[epoch] = self._made[plan.epoch]
        return replace(plan, epoch=epoch)

    def as_held(self, body: bytes) -> Plan:
        """Return the plan of these bytes as robots hold it: places as they travel, and the goals that robots find."""
        plan = decode_body(body)
        assert isinstance(plan, Plan)  # the type that was encoded
        return completed(plan, self._config)

    def _sound(self, shape: FloatArray) -> FloatArray:
        """Return a shape that was ordered as its plan tells it.

        Raises
        ------
        ShapeError
            If it cannot be used.
        """
        contour = load_shape(load_shape(shape).round(2))  # plans travel in centimeters
        if self._bounds is not None:
            check_inside(contour, self._bounds, "ordered shape")
        return contour

    def _check_way(self, morph: Morph) -> None:
        """Refuse a way that leads out of the arena or over an obstacle of the map.

        Raises
        ------
        ShapeError
            Naming the share of the way.
        """
        for share in SHARES:
            contour = morph.at(float(share))
            try:
                check_obstacles(contour, self._obstacles)
                if self._bounds is not None:
                    check_inside(contour, self._bounds, "shape")
            except ShapeError as error:
                raise ShapeError(f"after {100.0 * share:.0f} % of the way: {error}") from None

    def _beginning(
        self, present: Plan, move: Move, start: FloatArray, roster: Roster, lost: Sequence[Member]
    ) -> tuple[GoalSet, int]:
        """Return the goals with which a motion begins, and the epoch that their ids come from, 0 if from none.

        Robots can only go on with what they have if they are those whom the present plan was for. If one has died and
        another one is back, there are as many as before, but the one that is back has no goal.

        Raises
        ------
        ShapeError
            If the shape has no room for all goals where the motion begins.
        """
        here = GoalSet(goals_at(present, move.begins).round(2), present.goal_types)
        made = self._made.get(present.epoch)
        are_as_many = np.array_equal(np.sort(here.types), np.sort(roster.interleaved_types()))
        if made is not None and made.lost == _robots(lost) and are_as_many:
            return here, present.follows or present.epoch
        rows = self._kept_rows(here, np.arange(len(here.types)) if made is None else made.rows, roster, lost)
        goals = self._thinned(here, rows, start, roster, lost)
        if goals is None:
            goals = partition(start, roster, self._obstacles, self._config, keep_outs=self._bodies(lost))
        return GoalSet(goals.positions.round(2), goals.types), 0

    def _nearer(
        self, goals: GoalSet, contour: FloatArray, roster: Roster, lost: Sequence[Member], near: Sequence[Member]
    ) -> GoalSet:
        """Return the goals with other types, moved as little as these need, if that makes the ways shorter."""
        types = nearest_types(goals, near) if near else None
        if types is None:
            return goals
        others = GoalSet(goals.positions, types)
        moved = adapt(others, contour, roster, self._obstacles + self._bodies(lost), self._config)
        return goals if moved is None or distance_to_go(moved, near) >= distance_to_go(goals, near) else moved

    def _thinned(
        self, goals: GoalSet, rows: IntArray, contour: FloatArray, roster: Roster, lost: Sequence[Member]
    ) -> GoalSet | None:
        """Return those of the goals that stay, clear of bodies; None if they are too few, or cannot be got apart."""
        if len(rows) != roster.size:
            return None
        start = GoalSet(goals.positions[rows], goals.types[rows])
        return adapt(start, contour, roster, self._obstacles + self._bodies(lost), self._config)

    def _without_goals(self, epoch: int, contour: FloatArray, lost: Sequence[Member]) -> Plan:
        """Return a plan that says only what the robots find the goals from, or what drives them.

        Raises
        ------
        ShapeError
            If the shape cannot be used, or has no room for goals.
        """
        check_obstacles(contour, self._obstacles)
        bodies, roster = self._bodies(lost), self._roster.without(member.type for member in lost)
        method = self._config.method if self._task is Task.PARTITION else None
        nowhere, nobody = np.empty((0, 2)), np.empty(0, dtype=np.int64)
        outlines = self._obstacles + bodies
        plan = Plan(epoch, contour, outlines, nowhere, nobody, len(bodies), self._task, roster, method)
        held = self.as_held(encode_body(plan))
        if not is_contour(held.contour):
            raise ShapeError("the shape is too finely jagged for a plan as wide as this; simplify it")
        self._made = {epoch: _Made(np.arange(len(held.goals)), _robots(lost))}
        return replace(held, goals_crc=goals_crc(held.goals, held.goal_types))

    def _plan(self, epoch: int, contour: FloatArray, goals: GoalSet, lost: Sequence[Member]) -> Plan:
        """Return a plan that fits a radio packet; one that does not is an error before anything is remembered."""
        bodies = self._bodies(lost)
        plan = Plan(epoch, contour, self._obstacles + bodies, goals.positions, goals.types, len(bodies))
        encode_body(plan)
        return plan

    def _kept_rows(self, goals: GoalSet, full: IntArray, roster: Roster, lost: Sequence[Member]) -> IntArray:
        """Return which of the goals stay, ascending; too few of them if some type has more robots than before.

        First to go are goals that a body covers, then those that lost robots had taken; `full` is the row of each of
        the goals in `_full`.
        """
        covered = self._is_covered(goals, lost)
        had: list[int] = []
        for member in lost:
            made = self._made.get(member.epoch)
            if made is not None and 0 <= member.goal < len(made.rows):
                had.append(int(made.rows[member.goal]))
        taken = np.isin(full, had)
        order = np.lexsort((np.arange(len(taken)), taken, covered))
        kept = [row for group in roster.groups for row in order[goals.types[order] == group.type][: group.count]]
        return np.array(sorted(kept), dtype=np.int64)

    def _is_covered(self, goals: GoalSet, lost: Sequence[Member]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Return for each of the goals whether a lost robot's body is in its way."""
        reaches = self._roster.radii_of(goals.types) + self._config.gaps.obstacle_m
        covered = np.zeros(len(reaches), dtype=bool)
        places = shapely.points(goals.positions)
        for member in lost:
            if member.position is not None:
                where = shapely.linestrings([member.position, member.ahead or member.position])
                covered |= shapely.distance(places, where) < reaches + self._reach(member)
        return covered

    def _bodies(self, lost: Sequence[Member]) -> tuple[FloatArray, ...]:
        """Return a polygon around the body of each lost robot, wherever that is known."""
        return tuple(
            body_outline(member.position, self._reach(member), member.ahead)
            for member in lost
            if member.position is not None
        )

    def _reach(self, member: Member) -> float:
        """Return how far from where a lost robot believed to be its body may reach [m]."""
        radius = float(self._roster.radii_of(np.array([member.type]))[0])
        return radius + min(SIGMAS * member.sigma, DOUBT_MAX_M)


def _robots(members: Sequence[Member]) -> frozenset[NodeId]:
    return frozenset(member.robot for member in members)


def body_outline(position: tuple[float, float], radius: float, ahead: tuple[float, float] | None = None) -> FloatArray:
    """Return a polygon around a body that is somewhere between two points, (k, 2) counter-clockwise [m].

    It is the hull of the regular octagons that just hold a circle around each of the points, with corners in whole
    centimeters, as plans travel; `ahead` None: one octagon.
    """
    angles = (np.arange(CORNERS) + 0.5) * (2.0 * np.pi / CORNERS)
    octagon = (radius + ROUNDING_M) / np.cos(np.pi / CORNERS) * np.column_stack([np.cos(angles), np.sin(angles)])
    corners = np.vstack([np.array(end) + octagon for end in (position, ahead or position)])
    hull = shapely.MultiPoint(corners.round(2)).convex_hull
    return np.array(shapely.geometry.polygon.orient(hull).exterior.coords[:-1])


def nearest_inside(contour: FloatArray, position: tuple[float, float]) -> FloatArray | None:
    """Return the point of a shape that is nearest to a position outside it, (2,) [m]; None for one inside."""
    line = shapely.shortest_line(shapely.Point(position), shapely.Polygon(contour))
    return shapely.get_coordinates(line)[1] if line.length > 0.0 else None
