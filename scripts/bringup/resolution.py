"""Cross-checks before anything starts: the shape read, placed and tried, the map written out, the robots placed."""

from __future__ import annotations

from dataclasses import replace

import shapely

from bringup.camera_checks import check_camera
from bringup.cross_checks import (
    check_events,
    check_extensions,
    check_margins,
    check_rally_point,
    check_reach,
    check_size,
    first_plan_of,
    plan_maker,
)
from bringup.drive_checks import check_drive
from bringup.layout import make_scene, robot_types, walls
from bringup.origin import Origin, blamed
from bringup.scenario import MapSpec, Scenario
from bringup.shape_specs import ShapeSpec, StageSpec
from bringup.shaping import contour_from, reader
from bringup.staging import Staging, check_time, stage_of, stage_plan, written_shape, written_stage
from mission_computer.shape import check_inside
from mission_computer.shape.arena import load_arena
from mission_computer.stages import Stage
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.frames import HELLO_SIZE, ROUTE_ROW
from swarm_msgs_py.networking.config import NetworkConfig, NetworkModel
from swarm_msgs_py.partition import Method
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import Backend, RadioModel
from swarm_sim.radio.medium import longest_delay
from swarm_sim.simulation import Simulation


def resolve(scenario: Scenario, origin: Origin) -> Scenario:
    """Return the scenario with shape and map written out, after every check that needs no run.

    The result no longer depends on any file or library, so it can be run again elsewhere and later.

    Raises
    ------
    ConfigError
        One line that names the file or option, the key and the remedy.
    """
    scenario = _with_draws(scenario)
    with blamed(origin, "map"):
        scenario = with_map(scenario)
        assert scenario.map.bounds_m is not None  # just resolved
        check_size(scenario, scenario.map.bounds_m)
    with blamed(origin, "agent.decision.strategy"):
        check_extensions(scenario)
    with blamed(origin, "events"):
        check_events(scenario)
    with blamed(origin, "sim.camera"):
        check_camera(scenario)
    with blamed(origin, "sim.drive"):
        check_drive(scenario)
    with blamed(origin, "mission.partition.gaps"):
        check_margins(scenario)
    with blamed(origin, "sim.radio"):
        network_of(scenario)
    with blamed(origin, "shape"):
        contour = contour_of(scenario)
        _check_shape(contour, scenario, scenario.shape)
        maker = plan_maker(scenario, Roster.of(robot_types(scenario)), walls(scenario))
        plan = first_plan_of(maker, contour)
    with blamed(origin, "robots"):
        scene = make_scene(scenario)
        check_reach(scenario, scene, plan)
    scenario = _with_stages(scenario, contour, origin)
    for number, stage in enumerate(stages_of(scenario)):
        with blamed(origin, f"stages[{number}]"):
            check_time(scenario, number)
            _check_shape(stage.contour, scenario, scenario.stages[number].shape)
            plan = stage_plan(scenario, maker, stage, plan)
            check_reach(scenario, scene, plan)
    is_elsewhere = scenario.agent.decision.rally_point_m is not None
    with blamed(origin, "agent.decision.rally_point_m" if is_elsewhere else "mission.position_m"):
        check_rally_point(scenario, scene)
    with blamed(origin, "sim"):
        # The world checks how its settings fit together when it is made; the light back end is made in no time.
        light = replace(scenario.sim, physics=replace(scenario.sim.physics, backend=Backend.MASSDAMPER))
        Simulation(light, scene, scenario.seed).close()
    return _with_contour(scenario, contour)


def written_out(scenario: Scenario, origin: Origin) -> Scenario:
    """Return the scenario with shape and map written out, so that it depends on no file or library any more.

    Nothing else is checked: `resolve` does that, and takes the result as well.

    Raises
    ------
    ConfigError
        One line that names the file or option, the key and the remedy.
    """
    with blamed(origin, "map"):
        scenario = with_map(scenario)
    with blamed(origin, "shape"):
        contour = contour_of(scenario)
    return _with_contour(_with_stages(scenario, contour, origin), contour)


def contour_of(scenario: Scenario) -> FloatArray:
    """Return the contour of a scenario, (k, 2) counter-clockwise [m]."""
    return contour_from(scenario.shape, scenario)


def stages_of(scenario: Scenario) -> tuple[Stage, ...]:
    """Return the stages of a resolved scenario, as the mission computer is told of them."""
    read, shapes = reader(scenario), [stage.shape for stage in scenario.stages]
    return tuple(stage_of(spec, read(shape)) for spec, shape in zip(scenario.stages, shapes, strict=True) if shape)


def network_of(scenario: Scenario) -> NetworkConfig:
    """Return the settings of every radio's network: of the model that fits the scenario's radio, and patient enough.

    It must bear the latest hello that the radio delivers.
    Else a node that starts again could speak while others still route over what it said before (see
    `swarm_msgs_py.networking.dsdv`).

    Raises
    ------
    ConfigError
        If hellos can be later than any network is allowed to bear.
    """
    network, period_s = scenario.agent.network, scenario.sim.period_s
    if scenario.sim.radio.model is RadioModel.IDEAL:
        network = replace(network, model=NetworkModel.IDEAL)
    rows = min(network.rows_per_hello, scenario.robots.count + 1)
    hello = HELLO_SIZE + rows * ROUTE_ROW.itemsize
    delay_s = longest_delay(scenario.sim.radio, period_s, hello) * period_s
    try:
        return replace(network, delay_max_s=max(network.delay_max_s, delay_s))
    except ConfigError:
        raise ConfigError(
            f"hellos can come {delay_s:g} s late, which is too late for the mesh network; "
            "lower queue_s or delay_ticks_max, or raise budget_bps"
        ) from None


def _with_contour(scenario: Scenario, contour: FloatArray) -> Scenario:
    return replace(scenario, shape=written_shape(scenario.shape, contour, scenario.shape.label))


def _with_draws(scenario: Scenario) -> Scenario:
    """Return the scenario with the seed of its draws, if there are any: the run's, unless they have one."""
    partition = scenario.mission.partition
    if partition.method is not Method.FRACTALS or partition.fractals.seed is not None:
        return scenario
    partition = replace(partition, fractals=replace(partition.fractals, seed=scenario.seed))
    return replace(scenario, mission=replace(scenario.mission, partition=partition))


def _with_stages(scenario: Scenario, first: FloatArray, origin: Origin) -> Scenario:
    """Return the scenario with the contour of every stage written out."""
    staging, stages = Staging(first, reader(scenario)), list[StageSpec]()
    for number, spec in enumerate(scenario.stages):
        with blamed(origin, f"stages[{number}]"):
            stages.append(written_stage(spec, staging.next(spec)))
    return replace(scenario, stages=tuple(stages))


def _check_shape(contour: FloatArray, scenario: Scenario, spec: ShapeSpec | None) -> None:
    """Refuse a shape that is not in the arena, or over an obstacle."""
    assert scenario.map.bounds_m is not None  # a resolved scenario has its map written out
    check_inside(contour, scenario.map.bounds_m, f"'{spec.label}'" if spec is not None else "shape")
    _check_obstacles(contour, scenario)


def with_map(scenario: Scenario) -> Scenario:
    """Return the scenario with its map written out.

    Raises
    ------
    ConfigError
        If there is no such map, or its file is not sound.
    """
    return replace(scenario, map=_resolved_map(scenario.map))


def _resolved_map(spec: MapSpec) -> MapSpec:
    if spec.bounds_m is None:
        source = spec.file or spec.name
        assert source is not None  # MapSpec sees to it
        arena = load_arena(source)
        spec = MapSpec(name=arena.name, bounds_m=arena.bounds_m, obstacles=arena.obstacles)
    for obstacle in spec.obstacles:
        obstacle.polygon()
    return spec


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
