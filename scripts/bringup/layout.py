"""Where everything stands at the start: obstacles from the map, robots from the start rule and the seed."""

from __future__ import annotations

import math

import numpy as np
import shapely

from bringup.scenario import Scenario, rescaled_counts
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.sensing import PositionFix
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, NodeId, robot_name
from swarm_sim.scene import RobotSpec, Scene, check_scene

FENCE_M = 0.5  # thickness of the fence: farther than any robot is pushed into a wall
BATCH, BATCHES = 20, 200  # 4000 points are tried for one robot: if one in a thousand is free, e^-4 of the cases fail


def robot_types(scenario: Scenario) -> tuple[RobotType, ...]:
    """Return the type of each robot, in the order of robot ids."""
    return tuple(group.robot_type() for group in scenario.robots.types for _ in range(group.count))


def markers(scenario: Scenario) -> tuple[CoverMarker, ...]:
    """Return by what the overhead camera knows each robot, in the order of robot ids; none if there is no camera."""
    if not scenario.sim.camera.is_on:
        return ()
    worn = [(group.coverage_radius_m, color) for group in scenario.robots.types for color in group.colors]
    return tuple(CoverMarker(robot=NodeId(robot), color=color, radius=r) for robot, (r, color) in enumerate(worn))


def rally_point(scenario: Scenario) -> tuple[float, float]:
    """Return where a robot goes to hear a plan: where the scenario says, else to the mission computer [m]."""
    return scenario.agent.decision.rally_point_m or scenario.mission.position_m


def walls(scenario: Scenario) -> tuple[FloatArray, ...]:
    """Return what nobody crosses in a resolved scenario: the obstacles of the map, then the fence around the arena.

    The fence makes the bounds real for everybody who knows obstacles: bodies, proximity sensors, planners, the
    partition and the displacement bound. It is no obstacle of the map, and no figure draws it.

    Returns
    -------
    tuple of (k, 2) array
        Simple polygons [m]; the last four are the fence, whose inner edges are the bounds.
    """
    bounds = scenario.map.bounds_m
    assert bounds is not None  # a resolved scenario has its map written out
    return (*(obstacle.polygon() for obstacle in scenario.map.obstacles), *_fence(bounds))


def _fence(bounds: tuple[float, float, float, float]) -> tuple[FloatArray, ...]:
    x_min, y_min, x_max, y_max = bounds
    west, south, east, north = x_min - FENCE_M, y_min - FENCE_M, x_max + FENCE_M, y_max + FENCE_M
    sides = (
        (west, south, east, y_min),
        (x_max, south, east, north),
        (west, y_max, east, north),
        (west, south, x_min, north),
    )
    return tuple(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, y0, x1, y1 in sides)


def make_scene(scenario: Scenario) -> Scene:
    """Return the arena of a resolved scenario, with its robots placed.

    Raises
    ------
    ConfigError
        If there is no room for the robots, or explicit start points cannot be.
    """
    bounds = scenario.map.bounds_m
    assert bounds is not None  # a resolved scenario has its map written out
    obstacles = walls(scenario)
    types = robot_types(scenario)
    explicit = scenario.robots.start.positions_m
    starts = np.array(explicit, dtype=np.float64) if explicit else _drawn(scenario, types, obstacles, bounds)
    _check_edge(starts, types, bounds)
    sensors = sensor_carriers(scenario)
    robots = tuple(
        RobotSpec(
            NodeId(robot),
            kind,
            (float(starts[robot, 0]), float(starts[robot, 1])),
            float(rng_for(scenario.seed, "start-yaw", robot).uniform(-math.pi, math.pi)),
            robot in sensors,
        )
        for robot, kind in enumerate(types)
    )
    scene = Scene(robots, obstacles, bounds, scenario.mission.position_m, markers(scenario))
    check_scene(scene)
    return scene


def told_start(scenario: Scenario, scene: Scene, robot: NodeId) -> PositionFix | None:
    """Return where a robot is told to stand at the start: the truth and an error drawn from the seed (erratum E14)."""
    sigma = scenario.robots.start.known_within_m
    if sigma is None:
        return None
    error = rng_for(scenario.seed, "told-start", robot).normal(size=2) * sigma
    return PositionFix(np.array(scene.robots[robot].position) + error, sigma)


def _check_edge(starts: FloatArray, types: tuple[RobotType, ...], bounds: tuple[float, float, float, float]) -> None:
    """Refuse robots that would stand in the fence, in words that speak of the arena."""
    for robot, (kind, (x, y)) in enumerate(zip(types, starts, strict=True)):
        room = min(x - bounds[0], y - bounds[1], bounds[2] - x, bounds[3] - y)
        if room < kind.coverage_radius_m:
            raise ConfigError(
                f"{robot_name(NodeId(robot))} starts at ({x:g}, {y:g}), outside the arena or against its edge; "
                f"move it at least {kind.coverage_radius_m:g} m inside {list(bounds)}"
            )


def _drawn(
    scenario: Scenario,
    types: tuple[RobotType, ...],
    obstacles: tuple[FloatArray, ...],
    bounds: tuple[float, float, float, float],
) -> FloatArray:
    """Return (n, 2) start points, uniform in the start square; large robots choose first, since they need most room."""
    start = scenario.robots.start
    solid = shapely.union_all([shapely.Polygon(obstacle) for obstacle in obstacles])
    shapely.prepare(solid)
    radii = np.array([kind.coverage_radius_m for kind in types])
    points = np.full((len(types), 2), np.inf)
    for robot in np.lexsort((np.arange(len(types)), -radii)):
        keep_out = radii[robot] + start.gap_m
        low = np.maximum(np.array(bounds[:2]) + keep_out, -start.half_side_m)
        high = np.minimum(np.array(bounds[2:]) - keep_out, start.half_side_m)
        rng = rng_for(scenario.seed, "start", int(robot))
        for _ in range(BATCHES if (low <= high).all() else 0):
            candidates = rng.uniform(low, high, (BATCH, 2))
            offsets = candidates[:, None] - points[None]
            is_free = (np.hypot(offsets[..., 0], offsets[..., 1]) - radii[None] >= keep_out).all(axis=1)
            is_free &= ~shapely.dwithin(solid, shapely.points(candidates), keep_out)
            if is_free.any():
                points[robot] = candidates[np.argmax(is_free)]
                break
        else:
            placed = int(np.isfinite(points).all(axis=1).sum())
            raise ConfigError(
                f"no room for {robot_name(NodeId(int(robot)))} after {placed} of {len(types)} robots were placed in "
                f"|x|, |y| <= {start.half_side_m:g} m; enlarge start.half_side_m, lower start.gap_m or use fewer robots"
            )
    return points


def sensor_carriers(scenario: Scenario) -> frozenset[int]:
    """Return who carries a position sensor: the share, rounded up, spread over the types; drawn within a type."""
    counts = tuple(group.count for group in scenario.robots.types)
    total = math.ceil(scenario.robots.position_sensor_share * scenario.robots.count)
    carriers: set[int] = set()
    first = 0
    for group, carrying in zip(scenario.robots.types, rescaled_counts(counts, total), strict=True):
        drawn = rng_for(scenario.seed, "position-sensor", group.type).permutation(group.count)[:carrying]
        carriers.update(first + int(index) for index in drawn)
        first += group.count
    return frozenset(carriers)
