"""What robustness means, measured on the records of a run: when the network is apart, and when all agree again."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from scipy.sparse.csgraph import connected_components

from bringup.engine import TickRecord
from bringup.layout import robot_types, walls
from bringup.scenario import Scenario
from swarm_agent.planning.path_planner import lower_bound_planner
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.radio.links import LinkModel
from swarm_sim.scene import Scene
from swarm_sim.world.obstacles import ObstacleField

SPLIT_MIN_S, PART_MIN = 10.0, 3  # a shorter or smaller separation is a robot that lags behind, not a part
PROGRESS_S, PROGRESS_SHARE = 5.0, 0.1  # of what full speed would bring in that time
WATCHED = ("longest_split_s", "merged_at_s", "agreed_after_s", "busy_with_computer", "busy_without_computer")
"""Keys of `SplitWatch.summary`."""


class SplitWatch:
    """Watches true links, true motion and reported goals.

    The network is *apart* while the mission computer and a part of at least `PART_MIN` robots have no chain of links
    between them. Robots *agree* when all that live hold the plan in force and as many rows as each other, and have
    goals of their type, no two the same.

    A robot is *busy* when it is on its way to the goal that it reports, or there. On its way: in the last `PROGRESS_S`
    its true distance to that goal, straight or along the shortest path around the obstacles, shrank by at least
    `PROGRESS_SHARE` of what it can drive in that time. There: it reports that it is parked, and its true position is
    within the goal tolerance of the scenario. The goal is looked up in the plan that the robot itself holds.

    Parameters
    ----------
    scenario : Scenario
        Resolved.
    scene : Scene
    """

    def __init__(self, scenario: Scenario, scene: Scene) -> None:
        self._period = scenario.sim.period_s
        self._links = LinkModel(scenario.sim.radio.range_m, ObstacleField(scene.obstacles))
        self._antenna = np.array([scene.mission_position])
        self._kinds = robot_types(scenario)
        self._types = np.array([kind.type for kind in self._kinds])
        self._walls, self._goal_tolerance = walls(scenario), scenario.success.goal_tolerance_m
        self._progress = PROGRESS_SHARE * PROGRESS_S * scenario.agent.control.speed_max_m_s
        self._positions: deque[FloatArray] = deque(maxlen=round(PROGRESS_S / self._period) + 1)
        self._plans: dict[int, Plan] = {}
        self._plan: Plan | None = None
        self._apart: list[bool] = []
        self._agreed: list[bool] = []
        self._busy: dict[bool, list[float]] = {True: [], False: []}

    def take(self, record: TickRecord) -> None:
        """Take in one tick."""
        if record.plan is not None:
            self._plan = self._plans[record.plan.epoch] = record.plan
        self._positions.append(record.truth.positions)
        live = record.truth.alive
        antennas = np.concatenate([record.truth.positions, self._antenna])
        links = self._links.evaluate(antennas, np.append(live, True)).connected
        _, parts = connected_components(links, directed=False)
        outside = live & (parts[:-1] != parts[-1])
        sizes = np.bincount(parts[:-1][outside]) if outside.any() else np.zeros(1, dtype=np.int64)
        is_apart = bool(sizes.max() >= PART_MIN)
        self._apart.append(is_apart)
        self._agreed.append(self._is_agreed(record))
        if is_apart and self._plan is not None and len(self._positions) == self._positions.maxlen:
            is_busy = np.array([self._is_busy(record, robot) for robot in range(len(live))])
            for with_computer, members in ((True, live & ~outside), (False, outside)):
                if members.any():
                    self._busy[with_computer].append(float(is_busy[members].mean()))

    def summary(self) -> dict[str, Any]:
        """Return the longest split [s], the mean shares of busy robots in both parts, and how fast all agreed [s].

        The time to agreement runs from the end of the last long split to the tick from which on all agreed for good;
        None where there was none.
        """
        long = [(a, b) for a, b in self._spells() if (b - a) * self._period >= SPLIT_MIN_S]
        merged = long[-1][1] if long and long[-1][1] < len(self._apart) else None
        last_no = max((tick for tick, is_agreed in enumerate(self._agreed) if not is_agreed), default=-1)
        agreed = None
        if merged is not None and last_no + 1 < len(self._agreed):
            agreed = max(0.0, (last_no + 1 - merged) * self._period)
        return dict(
            zip(
                WATCHED,
                (
                    max(((b - a) * self._period for a, b in long), default=None),
                    None if merged is None else merged * self._period,
                    agreed,
                    _mean(self._busy[True]),
                    _mean(self._busy[False]),
                ),
                strict=True,
            )
        )

    def _spells(self) -> list[tuple[int, int]]:
        """Return first tick and end of every spell in which the network was apart."""
        edges = np.flatnonzero(np.diff(np.array([False, *self._apart, False], dtype=np.int8)))
        return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]

    def _is_agreed(self, record: TickRecord) -> bool:
        live = np.flatnonzero(record.truth.alive)
        reports = [record.reports.get(NodeId(int(robot))) for robot in live]
        if self._plan is None or any(report is None or report.epoch != self._plan.epoch for report in reports):
            return False
        goals = np.array([report.goal for report in reports if report is not None])
        if (goals < 0).any() or len(set(goals.tolist())) < len(goals):
            return False
        is_own_type = bool((self._plan.goal_types[goals] == self._types[live]).all())
        return is_own_type and len({report.rows for report in reports if report is not None}) == 1

    def _is_busy(self, record: TickRecord, robot: int) -> bool:
        report = record.reports.get(NodeId(robot))
        plan = self._plans.get(report.epoch) if report is not None else None
        if report is None or plan is None or not 0 <= report.goal < len(plan.goals):
            return False
        goal, before, now = plan.goals[report.goal], self._positions[0][robot], self._positions[-1][robot]
        if report.mode is Mode.PARKED:
            return float(np.hypot(*(goal - now))) <= self._goal_tolerance
        if np.hypot(*(goal - before)) - np.hypot(*(goal - now)) >= self._progress:
            return True
        planner = lower_bound_planner(self._walls, self._kinds[robot].coverage_radius_m)
        ways = [float(planner.costs(point, goal[None])[0]) for point in (before, now)]
        return bool(np.isfinite(ways).all()) and ways[0] - ways[1] >= self._progress


def _mean(shares: list[float]) -> float | None:
    return float(np.mean(shares)) if shares else None
