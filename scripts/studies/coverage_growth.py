"""How planning and whole missions grow with the number of robots: balls of growing radius, ranges of 50 m."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

import numpy as np

from studies.coverage_mission import CoverageMission
from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.expansion import expand
from swarm_agent.coverage.layout import plan_layout
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.coverage import CoverageProbe
from swarm_sim.points.config import PointSimConfig

GROWTH_HEADER = "radius [m]  method     robots  covered   CPU [s]"
ROBOTS_MAX, TICKS_MAX = 20_000, 1000
SPARE = 5  # robots more than the layout asks for, in a mission


def growth(radii: Sequence[float], mission_radii: Sequence[float]) -> Iterator[str]:
    """Yield a row for each way to place robots in each ball, and one for each whole mission.

    Parameters
    ----------
    radii : sequence of float
        Of the balls in which places are planned [m].
    mission_radii : sequence of float
        Of those that message-level robots cover [m].
    """
    config, leader = CoverageConfig(), np.zeros(3)
    for radius in radii:
        solid = solid_from({"kind": "ball", "radius_m": radius})
        probe = CoverageProbe(solid, config.range_m, seed=0)
        began = time.process_time()
        paper = expand(solid, leader, CoverageConfig(rule=Rule.RANDOM), ROBOTS_MAX, rng_for(0, "growth")).positions
        yield _row(radius, "frontier", paper, probe, time.process_time() - began)
        began = time.process_time()
        layout = plan_layout(solid, leader, config).positions
        yield _row(radius, "layout", layout, probe, time.process_time() - began)
    for radius in mission_radii:
        solid = solid_from({"kind": "ball", "radius_m": radius})
        placement = CoverageConfig(placement=0.9)
        robots = len(plan_layout(solid, leader, placement).positions) + SPARE
        began = time.process_time()
        shape = {"kind": "ball", "radius_m": radius}
        mission = CoverageMission(shape, placement, PointSimConfig(), robots, 0)
        places = mission.run(TICKS_MAX).positions
        probe = CoverageProbe(solid, config.range_m, seed=0)
        yield _row(radius, "mission", places, probe, time.process_time() - began)


def _row(radius: float, method: str, places: np.ndarray, probe: CoverageProbe, cpu_s: float) -> str:
    covered = probe.measure(places).covered_fraction
    return f"{radius:10.0f}  {method:9s} {len(places):7d}  {covered:.5f}  {cpu_s:8.2f}"
