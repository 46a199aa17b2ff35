"""What a run starts with: robots, obstacles, bounds, antenna."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely import Point, Polygon, STRtree
from shapely.validation import explain_validity

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import MISSION, FloatArray, NodeId, robot_name


@dataclass(frozen=True, slots=True, eq=False)
class RobotSpec:
    """One robot at the start.

    Attributes
    ----------
    id : NodeId
    type : RobotType
    position : (x, y)
        World frame [m].
    yaw : float
        Heading [rad].
    has_position_sensor : bool
        Gets a `PositionFix` every tick.
    """

    id: NodeId
    type: RobotType
    position: tuple[float, float]
    yaw: float
    has_position_sensor: bool


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """The arena and who is in it.

    Attributes
    ----------
    robots : tuple of RobotSpec
        Ascending ids.
    obstacles : tuple of (k, 2) array
        Simple polygons, either orientation [m].
    bounds : (x_min, y_min, x_max, y_max)
        The arena [m].
    mission_position : (x, y)
        Antenna of the mission computer [m].
    markers : tuple of CoverMarker
        Covers of the robots, one each in their order, where a camera looks at them.
    """

    robots: tuple[RobotSpec, ...]
    obstacles: tuple[FloatArray, ...]
    bounds: tuple[float, float, float, float]
    mission_position: tuple[float, float]
    markers: tuple[CoverMarker, ...] = ()


def check_scene(scene: Scene) -> None:
    """Refuse a scene that no physics could start from.

    Raises
    ------
    ConfigError
        If there is no robot, ids are not ascending addresses, a number is not finite, the bounds are empty, an obstacle
        is no simple polygon, a robot is outside the bounds or in an obstacle, two robots overlap, or the antenna is in
        an obstacle. One line with what to change.
    """
    ids = [robot.id for robot in scene.robots]
    if not ids:
        raise ConfigError("scene: there is no robot; add at least one")
    if ids != sorted(set(ids)) or ids[0] < 0 or ids[-1] >= MISSION:
        raise ConfigError(f"scene: robot ids must be ascending, unique and in 0..{MISSION - 1}, got {ids}")
    x_min, y_min, x_max, y_max = scene.bounds
    if not (np.isfinite(scene.bounds).all() and x_min < x_max and y_min < y_max):
        raise ConfigError(f"scene: bounds must be x_min < x_max and y_min < y_max, got {scene.bounds}")
    polygons = [_polygon(number, corners) for number, corners in enumerate(scene.obstacles)]
    _check_robots(scene, polygons)
    antenna = Point(scene.mission_position)
    for number, polygon in enumerate(polygons):
        if polygon.intersects(antenna):
            raise ConfigError(
                f"scene: the mission computer's antenna at {_at(scene.mission_position)} is in obstacle {number}; "
                "move one of them"
            )


def _polygon(number: int, corners: FloatArray) -> Polygon:
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        raise ConfigError(f"scene: obstacle {number} needs at least 3 corners of 2 finite numbers")
    polygon = Polygon(corners)
    if not polygon.is_valid or polygon.area <= 0.0:
        why = explain_validity(polygon) if not polygon.is_valid else "no area"
        raise ConfigError(f"scene: obstacle {number} is not a simple polygon ({why}); correct its corners")
    return polygon


def _check_robots(scene: Scene, polygons: list[Polygon]) -> None:
    x_min, y_min, x_max, y_max = scene.bounds
    circles = []
    for robot in scene.robots:
        (x, y), radius = robot.position, robot.type.coverage_radius_m
        if not np.isfinite([x, y, robot.yaw]).all():
            raise ConfigError(f"scene: {robot_name(robot.id)} starts at a place that is not a number; correct it")
        if not (x_min <= x <= x_max and y_min <= y <= y_max):
            raise ConfigError(
                f"scene: {robot_name(robot.id)} starts at {_at(robot.position)}, outside the bounds {scene.bounds}; "
                "move it inside"
            )
        circles.append((Point(x, y), radius))
        for number, polygon in enumerate(polygons):
            if polygon.distance(circles[-1][0]) < radius:
                raise ConfigError(
                    f"scene: {robot_name(robot.id)} starts at {_at(robot.position)} in or against obstacle {number}; "
                    f"keep its center at least {radius:g} m away"
                )
    _check_gaps(scene)


def _check_gaps(scene: Scene) -> None:
    reach = 2.0 * max(robot.type.coverage_radius_m for robot in scene.robots)
    points = [Point(robot.position) for robot in scene.robots]
    near = STRtree(points).query(points, predicate="dwithin", distance=reach)
    for i, j in sorted((int(i), int(j)) for i, j in near.T if i < j):
        first, second = scene.robots[i], scene.robots[j]
        needed = first.type.coverage_radius_m + second.type.coverage_radius_m
        apart = float(np.hypot(*np.subtract(first.position, second.position)))
        if apart < needed:
            raise ConfigError(
                f"scene: {robot_name(first.id)} and {robot_name(second.id)} overlap at the start "
                f"({apart:.3f} m apart, they need {needed:g} m); move one of them"
            )


def _at(position: tuple[float, float]) -> str:
    return f"({position[0]:g}, {position[1]:g})"
