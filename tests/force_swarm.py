"""Point robots under a force law: the smallest world in which a formation by forces can be tried."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from rosters import FIELD

from mission_computer.shape.arena import load_arena
from swarm_agent.forces.config import ForceConfig
from swarm_agent.forces.force_drive import ForceDrive
from swarm_agent.forces.force_law import ForceLaw, Others
from swarm_agent.planning.line_of_sight import Walls
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray

PERIOD = 0.5
SUBSTEPS = 10
LAG = 0.1  # [s], of the velocity behind its setpoint
RADIO_RANGE = 25.0
HALF_SIDE = 45.0
START_GAP = 0.3
REST_SPEED, HOLD = 0.01, 3.0  # spec 14.4


@dataclass(frozen=True)
class Outcome:
    """What came of it.

    Attributes
    ----------
    settled_after : float or None
        From then on all were inside and at rest for the hold time [s].
    inside : float
        Share of the robots inside at the end.
    resting : float
        Share of them that were slow at the end.
    min_gap, min_clearance : float
        Least gap between coverage circles, and to obstacles, after the first ten seconds [m].
    starts, positions : (n, 2) array
        First and last places [m].
    traveled : float
        Total displacement [m].
    """

    settled_after: float | None
    inside: float
    resting: float
    min_gap: float
    min_clearance: float
    starts: FloatArray
    positions: FloatArray
    traveled: float


def field_radii() -> FloatArray:
    """Return the coverage radii of the fifty robots of the field."""
    return FIELD.radii_of(FIELD.interleaved_types())


def field_obstacles() -> tuple[FloatArray, ...]:
    """Return the six obstacles of the field."""
    return tuple(obstacle.polygon() for obstacle in load_arena("arena_main").obstacles)


def scattered(
    radii: FloatArray, obstacles: Sequence[FloatArray], seed: int, half_side: float = HALF_SIDE
) -> FloatArray:
    """Return random free start points, (n, 2)."""
    rng = rng_for(seed, "force-swarm")
    solid = shapely.union_all([shapely.Polygon(obstacle) for obstacle in obstacles])
    placed: list[FloatArray] = []
    while len(placed) < len(radii):
        point, radius = rng.uniform(-half_side, half_side, 2), radii[len(placed)]
        apart = all(
            np.hypot(*(point - other)) > radius + radii[index] + START_GAP for index, other in enumerate(placed)
        )
        # The distance to no obstacles is not a number.
        if apart and not solid.distance(shapely.Point(point)) <= radius + START_GAP:
            placed.append(point)
    return np.array(placed)


def form(
    law: ForceLaw,
    config: ForceConfig,
    contour: FloatArray,
    starts: FloatArray,
    radii: FloatArray,
    obstacles: Sequence[FloatArray] = (),
    *,
    deadline: float = 400.0,
    period: float = PERIOD,
    watch: Callable[[int, FloatArray, FloatArray], None] | None = None,
) -> Outcome:
    """Drive the swarm until it has settled; radios reach 25 m in line of sight, and hellos are a tick old."""
    drive = ForceDrive(config, period, len(radii))
    shape = shapely.Polygon(contour)
    shapely.prepare(shape)
    solid = shapely.union_all([shapely.Polygon(obstacle) for obstacle in obstacles])
    walls = Walls(tuple(obstacles))
    positions, velocities = starts.copy(), np.zeros_like(starts)
    told, told_velocities = positions.copy(), velocities.copy()
    min_gap = min_clearance = np.inf
    traveled, since = 0.0, None
    step = period / SUBSTEPS
    for tick in range(int(deadline / period)):
        others = Others(told + period * told_velocities, radii, _heard(told, walls))
        commands = drive.step(law, positions, radii, others, told_velocities)
        told, told_velocities = positions.copy(), velocities.copy()
        quiet = True
        for _ in range(SUBSTEPS):
            velocities = commands + (velocities - commands) * np.exp(-step / LAG)
            positions = positions + velocities * step
            speeds = np.hypot(*velocities.T)
            traveled += speeds.sum() * step
            quiet &= bool((speeds < REST_SPEED).all())
        if tick * period > 10.0:
            min_gap = min(min_gap, _least_gap(positions, radii))
            if obstacles and tick % 4 == 0:
                clearance = shapely.distance(solid, shapely.points(positions)) - radii
                min_clearance = min(min_clearance, float(clearance.min()))
        if watch:
            watch(tick, positions, velocities)
        inside = shapely.contains_xy(shape, positions[:, 0], positions[:, 1])
        since = None if not (quiet and inside.all()) else tick * period if since is None else since
        if since is not None and (tick + 1) * period - since >= HOLD + 2.0:
            break
    return Outcome(
        since,
        float(inside.mean()),
        float((np.hypot(*velocities.T) < REST_SPEED).mean()),
        min_gap,
        min_clearance,
        starts,
        positions,
        traveled,
    )


def _heard(positions: FloatArray, walls: Walls) -> BoolArray:
    """Return who hears whom, (n, n)."""
    near = np.hypot(*(positions[:, None] - positions).T) < RADIO_RANGE
    np.fill_diagonal(near, False)
    for robot in range(len(positions)):
        candidates = np.flatnonzero(near[robot, robot:]) + robot
        seen = walls.clear_from(positions[robot], positions[candidates])
        near[robot, candidates] = near[candidates, robot] = seen
    return near


def _least_gap(positions: FloatArray, radii: FloatArray) -> float:
    gaps = np.hypot(*(positions[:, None] - positions).T) - radii[:, None] - radii
    np.fill_diagonal(gaps, np.inf)
    return float(gaps.min())
