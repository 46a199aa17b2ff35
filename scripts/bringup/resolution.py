"""Cross-checks before anything starts: the shape read, placed and tried, the map written out, the robots placed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from bringup.layout import make_scene, robot_types
from bringup.scenario import MapSpec, Scenario, ShapeSpec
from bringup.scenario_file import Origin
from mission_computer.partition import check_fits
from mission_computer.roster import Roster
from mission_computer.shape import check_inside, load_shape
from mission_computer.shape.arena import load_arena
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.errors import ConfigError, ShapeError
from swarm_msgs_py.types import FloatArray, robot_name
from swarm_sim.config import Backend
from swarm_sim.scene import Scene
from swarm_sim.simulation import Simulation


def resolve(scenario: Scenario, origin: Origin) -> Scenario:
    """Return the scenario with shape and map written out, after every check that needs no run.

    The result no longer depends on any file or library, so it can be run again elsewhere and later.

    Raises
    ------
    ConfigError
        One line that names the file or option, the key and the remedy.
    """
    with _blamed(origin, "map"):
        scenario = replace(scenario, map=_resolved_map(scenario.map))
    with _blamed(origin, "shape"):
        contour = _contour(scenario.shape)
        assert scenario.map.bounds_m is not None  # just resolved
        check_inside(contour, scenario.map.bounds_m, f"'{_shape_name(scenario.shape)}'")
        _check_obstacles(contour, scenario)
        obstacles = tuple(obstacle.polygon() for obstacle in scenario.map.obstacles)
        roster = Roster.of(robot_types(scenario))
        check_fits(contour, roster, obstacles, scenario.mission.partition, seed=scenario.seed)
    with _blamed(origin, "robots"):
        scene = make_scene(scenario)
        _check_reach(contour, scene, scenario)
    with _blamed(origin, "sim"):
        # The world checks how its settings fit together when it is made; the light back end is made in no time.
        light = replace(scenario.sim, physics=replace(scenario.sim.physics, backend=Backend.MASSDAMPER))
        Simulation(light, scene, scenario.seed).close()
    points = tuple((float(x), float(y)) for x, y in contour)
    return replace(scenario, shape=ShapeSpec(name=_shape_name(scenario.shape), points=points))


def contour_of(scenario: Scenario) -> FloatArray:
    """Return the contour of a resolved scenario, (k, 2) counter-clockwise [m]."""
    return _contour(scenario.shape)


@contextmanager
def _blamed(origin: Origin, key: str) -> Iterator[None]:
    """Put the place to mend in front of what is wrong with `key`."""
    try:
        yield
    except (ConfigError, ShapeError) as error:
        raise ConfigError(f"{origin.of(key)}: {error}") from None


def _contour(spec: ShapeSpec) -> FloatArray:
    # Points are handed over as JSON, which load_shape reads in every form that a file may have.
    source = json.dumps(spec.points) if spec.points is not None else spec.file or spec.name
    assert source is not None  # ShapeSpec sees to it
    return load_shape(
        source, scale=spec.scale, rotation=math.radians(spec.rotation_deg), translation=spec.translation_m
    )


def _shape_name(spec: ShapeSpec) -> str:
    return spec.name or (Path(spec.file).stem if spec.file else "inline shape")


def _resolved_map(spec: MapSpec) -> MapSpec:
    if spec.bounds_m is None:
        source = spec.file or spec.name
        assert source is not None  # MapSpec sees to it
        arena = load_arena(source)
        spec = MapSpec(name=arena.name, bounds_m=arena.bounds_m, obstacles=arena.obstacles)
    for obstacle in spec.obstacles:
        obstacle.polygon()
    return spec


def _check_reach(contour: FloatArray, scene: Scene, scenario: Scenario) -> None:
    """Refuse robots that no path leads into the shape."""
    center = shapely.get_point(shapely.maximum_inscribed_circle(shapely.Polygon(contour)), 0)
    target = np.array([[center.x, center.y]])
    walled_off = []
    for robot in scene.robots:
        planner = planner_for(scene.obstacles, robot.type.coverage_radius_m, scenario.agent.planning)
        if not np.isfinite(planner.costs(np.array(robot.position), target)).all():
            walled_off.append(robot_name(robot.id))
    if walled_off:
        raise ConfigError(
            f"no path leads from {', '.join(walled_off[:4])}{', ...' if len(walled_off) > 4 else ''} to the shape; "
            "move the obstacles apart, or start elsewhere (another seed, start.half_side_m, start.positions_m)"
        )


def _check_obstacles(contour: FloatArray, scenario: Scenario) -> None:
    shape = shapely.Polygon(contour)
    for obstacle in scenario.map.obstacles:
        common = shape.intersection(shapely.Polygon(obstacle.polygon()))
        if common.area > 0.0:
            place = common.representative_point()
            raise ConfigError(
                f"lies over obstacle '{obstacle.name}' near ({place.x:.1f}, {place.y:.1f}); "
                "move one of them, for example with shape.translation_m"
            )
