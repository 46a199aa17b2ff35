"""Small valid ticks for tests of what watches and records a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bringup.engine import TickRecord
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import AgentReport, LocalizationReport, Mode, Positioning
from swarm_msgs_py.types import NodeId
from swarm_sim.simulation import RadioTraffic, TickTruth

PERIOD = 0.5
SAMPLES = 10
Points = Sequence[Sequence[float]]


def make_plan(goals: Points, contour: Points = ((-5, -5), (5, -5), (5, 5), (-5, 5))) -> Plan:
    return Plan(
        1,
        np.array(contour, dtype=float),
        (),
        np.array(goals, dtype=float).reshape(-1, 2),
        np.ones(len(goals), dtype=np.int64),
    )


def make_report(position: Sequence[float], goal: int, mode: Mode = Mode.PARKED) -> AgentReport:
    return AgentReport(
        position=np.array(position, dtype=float),
        velocity=np.zeros(2),
        covariance=np.eye(2),
        yaw=0.0,
        mode=mode,
        localization=LocalizationReport(
            Positioning.LOCALIZED,
            lost_by_beacons=False,
            lost_by_sigma=False,
            shared=0.0,
            accepted=0,
            rejected=0,
            disagreements=0,
        ),
        epoch=1,
        goal=goal,
        path=np.empty((0, 2)),
        neighbors=(),
        beacons=0,
        routes=0,
        rows=0,
        counters=RadioCounters(),
    )


def make_tick(
    tick: int,
    points: Points,
    goals: Sequence[int] | None = None,
    *,
    speed: float = 0.0,
    plan: Plan | None = None,
    lost: frozenset[NodeId] = frozenset(),
    overlaps: tuple[tuple[int, int], ...] = (),
    clearance: float = 1.0,
) -> TickRecord:
    """Return a tick in which every robot stays at its point, with `speed` along x at all samples."""
    positions, count = np.array(points, dtype=float), len(points)
    velocities = np.tile([speed, 0.0], (count, 1))
    alive = np.array([NodeId(robot) not in lost for robot in range(count)])
    truth = TickTruth(
        tick=tick,
        time=tick * PERIOD,
        positions=positions,
        yaws=np.zeros(count),
        velocities=velocities,
        heights=np.zeros(count),
        alive=alive,
        samples=np.tile(positions, (SAMPLES, 1, 1)),
        sample_velocities=np.tile(velocities, (SAMPLES, 1, 1)),
        min_clearance=clearance,
        overlaps=overlaps,
        radio=RadioTraffic(frames=count, bytes=10 * count, peak_bps=160.0, neighborhood_bps=240.0, dropped=1),
    )
    wanted = range(count) if goals is None else goals
    reports = {NodeId(robot): make_report(points[robot], goal) for robot, goal in enumerate(wanted) if alive[robot]}
    return TickRecord(tick, truth, reports, None, plan, (), lost)
