"""Decides when a formation run is over: achieved, or not any more to be achieved."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import shapely

from bringup.engine import FormationRecord
from bringup.goal_agreement import GoalAgreement
from bringup.labels import first_few
from bringup.scenario import SuccessSpec
from bringup.verdict import Verdict
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import AgentReport, MissionReport
from swarm_msgs_py.plan_course import Course, lineage
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.types import MISSION, FloatArray, NodeId, robot_name
from swarm_sim.metrics.settling import settled_samples

__all__ = ["Supervisor", "Verdict"]

SENSOR_SOURCE = "robots.position_sensor_share"
CAMERA_SOURCE = "the camera gave them no fix; see the alerts and sim.camera"
"""What to look at when robots do not know where they are."""


class Supervisor:
    """Watches the records of a run, from true states alone (spec 14.4); the robots never hear of it.

    Parameters
    ----------
    robots : tuple of NodeId
        All robots, ascending.
    success : SuccessSpec
    period_s : float
        Duration of a tick [s].
    duration_s : float
        Simulated time limit [s].
    complete_s : float
        When the last robot has been switched on that the scenario adds; nothing is achieved before [s].
    is_under_camera : bool
        Whether robots learn from an overhead camera where they are.

    Attributes
    ----------
    plan : Plan or None
        The plan in force.
    course : Course
        All plans, which tell where the shape was when.
    stages : list of int
        Tick in which each stage was ordered, the first shape included; of one that was passed over, when the next was.
    goals : dict of NodeId to int
        Goal that each robot last reported, -1 for none.
    at_goal : int
        Live robots within tolerance of their goal at the end of the last tick; of a plan without goals, those inside
        the shape.
    has_changed_shape : bool
        Whether a plan was replaced by one for another contour; new goals in the same contour, after losses, are none.
    goal_agreement : GoalAgreement
        Whether robots that find their goals by themselves found the same.
    """

    def __init__(  # noqa: PLR0913 - all that a verdict depends on
        self,
        robots: tuple[NodeId, ...],
        success: SuccessSpec,
        period_s: float,
        duration_s: float,
        *,
        complete_s: float = 0.0,
        is_under_camera: bool = False,
    ) -> None:
        self._robots = robots
        self._success = success
        self._period = period_s
        self._duration = duration_s
        self._complete = complete_s
        self._position_source = CAMERA_SOURCE if is_under_camera else SENSOR_SOURCE
        self._contour: shapely.Polygon | None = None  # as it is at the end of the tick
        self._drawn: FloatArray | None = None  # the points of it
        self._mission: MissionReport | None = None  # the last one
        self._settled_since: float | None = None
        self._tick = 0  # that was watched last
        self._reports: dict[NodeId, AgentReport] = {}
        self._distances: dict[NodeId, float] = {}
        self._lost: frozenset[NodeId] = frozenset()
        self.plan: Plan | None = None
        self.course = Course()
        self.stages: list[int] = []
        self.goals: dict[NodeId, int] = {}
        self.at_goal = 0
        self.has_changed_shape = False
        self.goal_agreement = GoalAgreement()

    def watch(self, record: FormationRecord) -> Verdict | None:
        """Take in one tick; return the verdict when there is one."""
        self._take(record)
        self.goal_agreement.take(record)
        rows = np.array([row for row, robot in enumerate(self._robots) if robot not in self._lost], dtype=np.int64)
        end = record.truth.time + self._period
        if not len(rows):
            return Verdict(False, f"all {len(self._robots)} robots are lost; see the alerts for why")
        if MISSION in self._lost and self.plan is None:
            return Verdict(False, "the mission computer died before it made a plan; see the alerts for why")
        self._watch_motion(record, rows)
        held = end - self._settled_since if self._settled_since is not None else -1.0
        # Sample times are sums of fractions of a tick; a hold may fall short of itself by rounding.
        if held >= self._success.hold_s - 1e-9 and self.at_goal == len(rows) and not self._is_awaiting(end):
            return self._settled(len(rows))
        if end >= self._duration - 1e-9:
            return Verdict(False, f"time limit of {self._duration:g} s: {self._tally()}{self._shortfall()}")
        return None

    def interrupted(self, time: float) -> Verdict:
        """Return the verdict of a run that the operator ended at `time` [s]."""
        return Verdict(False, f"interrupted by the operator at {time:.1f} s: {self._tally()}")

    def unfinished(self, time: float) -> Verdict:
        """Return the verdict that is on disk while the run goes on, at `time` [s]."""
        return Verdict(False, f"still running at {time:.1f} s: {self._tally()}")

    def _settled(self, live: int) -> Verdict:
        """Return the verdict on a swarm that is at rest at its goals, which counts only if enough of it lives."""
        needed = math.ceil(self._success.live_share_min * len(self._robots) - 1e-9)
        if live < needed:
            too_few = f"only {live} of {len(self._robots)} robots live, {needed} must (success.live_share_min)"
            return Verdict(False, f"{too_few}; {self._tally()}, at rest since {self._settled_since:.1f} s")
        if self._stages_left:
            return Verdict(False, f"{self._tally()}, at rest since {self._settled_since:.1f} s{self._missing_stages()}")
        what = f"last of {len(self.stages)} shapes" if len(self.stages) > 1 else "shape"
        return Verdict(True, f"{what} formed: {self._tally()}, at rest since {self._settled_since:.1f} s")

    @property
    def _stages_left(self) -> int:
        return self._mission.stages_left if self._mission is not None else 0

    def _is_awaiting(self, time: float) -> bool:
        """Return whether another shape, or another robot, is still to come."""
        if time <= self._complete:
            return True
        is_over = MISSION in self._lost or (self._mission is not None and self._mission.is_broken_off)
        return self._stages_left > 0 and not is_over

    def _missing_stages(self) -> str:
        """Return why shapes are missing, "" if none are."""
        if not self._stages_left or self._mission is None:
            return ""
        stages = f"{self._stages_left} {'stage' if self._stages_left == 1 else 'stages'} to come"
        if self._mission.is_broken_off:
            return f"; {stages}, but stage {self._mission.stage + 1} was refused; see the alerts for why"
        return f"; {stages}, but the mission computer is off" if MISSION in self._lost else f"; {stages}"

    def _take(self, record: FormationRecord) -> None:
        dead = {robot for robot, alive in zip(self._robots, record.truth.alive, strict=True) if not alive}
        self._lost, self._tick = record.lost | dead, record.tick
        for robot, report in record.reports.items():
            self.goals[robot], self._reports[robot] = report.goal, report
        if record.mission is not None:
            self._mission = record.mission
        if record.plan is not None:
            self.has_changed_shape |= self.plan is not None and not np.array_equal(
                self.plan.contour, record.plan.contour
            )
            self.plan = record.plan
            self.course.put(record.tick, record.plan)
            self._settled_since = None
        if self.plan is not None:
            ordered = 1 + (self._mission.stage if self._mission is not None else 0)
            self.stages += [record.tick] * (ordered - len(self.stages))
        self._draw_shape(record.tick + 1)

    def _draw_shape(self, tick: int) -> None:
        """Take note of where the shape is at the beginning of a tick."""
        if self.plan is None:
            return
        contour = contour_at(self.course.at(tick), tick)
        if contour is not self._drawn:
            self._drawn, self._contour = contour, shapely.Polygon(contour)
            shapely.prepare(self._contour)

    def _watch_motion(self, record: FormationRecord, rows: np.ndarray) -> None:
        """Update who is at the goal, and since when everybody has been at rest inside the contour."""
        samples, speeds = record.truth.samples[:, rows], record.truth.sample_velocities[:, rows]
        self._distances = self._goal_distances(record, rows)
        self.at_goal = sum(map(self._is_there, self._distances.values()))
        if self.plan is None or self._contour is None:
            return
        if self.plan.motion is not None and record.tick < self.plan.motion.ends:
            self._settled_since = None  # on its way, or about to be
            return
        settled = settled_samples(samples, speeds, self._contour, self._success.speed_max_m_s)
        unsettled = np.flatnonzero(~settled)
        first = int(unsettled[-1]) + 1 if len(unsettled) else 0
        if first == len(settled):
            self._settled_since = None
        elif len(unsettled) or self._settled_since is None:
            self._settled_since = record.truth.time + self._period * (first + 1) / len(settled)

    def _goal_distances(self, record: FormationRecord, rows: np.ndarray) -> dict[NodeId, float]:
        """Return the distance of each live robot from its goal at the end of the tick [m], inf without a goal.

        In a plan without goals, the shape is the goal of everybody who has heard of it.
        """
        if self.plan is not None and self._contour is not None and not self.plan.task.has_goals:
            gaps = shapely.distance(self._contour, shapely.points(record.truth.samples[-1, rows]))
            robots = [self._robots[row] for row in rows]
            return {
                robot: float(gap) if self._has_heard(robot, self.plan) else float("inf")
                for robot, gap in zip(robots, gaps, strict=True)
            }
        goals = np.empty((0, 2)) if self.plan is None else self._goals(self.plan, record.tick + 1)
        distances = {}
        for row in rows:
            robot = self._robots[row]
            goal = self.goals.get(robot, -1)
            distances[robot] = float("inf")
            if 0 <= goal < len(goals):
                offset = record.truth.samples[-1, row] - goals[goal]
                distances[robot] = float(np.hypot(*offset))
        return distances

    def _goals(self, plan: Plan, tick: int) -> FloatArray:
        """Return the goals at the beginning of a tick, by the ids of the newest plan, (n, 2) [m]."""
        present = self.course.at(tick)
        return goals_at(present if lineage(present) == lineage(plan) else plan, tick)

    def _has_heard(self, robot: NodeId, plan: Plan) -> bool:
        """Return whether a robot has reported to hold a plan, or a later one."""
        report = self._reports.get(robot)
        return report is not None and report.epoch >= plan.epoch

    def _is_there(self, distance: float) -> bool:
        """Return whether a robot this far from its goal [m] has reached it; a shape is reached when it is inside."""
        return distance <= (self._success.goal_tolerance_m if self._has_goals else 0.0)

    @property
    def _has_goals(self) -> bool:
        return self.plan is None or self.plan.task.has_goals

    def _tally(self) -> str:
        lost = len(self._lost - {MISSION})
        dead = f", {lost} lost" if lost else ""
        place = "at their goals" if self._has_goals else "inside the shape"
        return f"{self.at_goal} of {len(self._robots) - lost} robots {place}{dead}"

    def _count(self, holds: Callable[[AgentReport], bool]) -> int:
        """Return of how many live robots the last report `holds`."""
        return sum(robot in self._reports and holds(self._reports[robot]) for robot in self._distances)

    def _shortfall(self) -> str:
        """Return what the shape, or the next one, was waiting for."""
        if self.plan is None:
            return "; no plan was made"
        blind = self._count(lambda report: not np.isfinite(report.position).all())
        if blind:
            return f"; {blind} have no position ({self._position_source})"
        silent = len(self._distances) - self._count(lambda _: True)
        if silent:
            return f"; {silent} never answered; see the alerts for why"
        epoch = self.plan.epoch
        deaf = self._count(lambda report: report.epoch < epoch)
        if deaf:
            why = "the mission computer is off" if MISSION in self._lost else "out of radio range, or frames lost"
            return f"; {deaf} never heard the plan ({why})"
        motion = self.plan.motion
        if motion is not None and self._tick < motion.ends:
            return f"; the shape was still moving{self._missing_stages()}"
        return self._missing_stages() or self._strays()

    def _strays(self) -> str:
        """Return who is not at the goal, and how far from it."""
        far = sorted(
            ((-d, robot) for robot, d in self._distances.items() if not self._is_there(d)),
        )
        if not far:
            return "; not at rest inside the shape"
        named = [
            f"{robot_name(robot)} {-d:.1f} m away" if np.isfinite(d) else f"{robot_name(robot)} without a goal"
            for d, robot in far
        ]
        return f"; {first_few(named)}"
