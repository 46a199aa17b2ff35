from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from bringup.compose import ScenarioActors
from bringup.layout import make_scene, walls
from bringup.resolution import resolve
from bringup.scenario import Scenario, StartSpec
from bringup.scenario_file import load_scenario
from mission_computer.shape.arena import Obstacle
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import NodeId
from swarm_sim.scene import Scene


@pytest.fixture(scope="module")
def swarm() -> Scenario:
    return resolve(*load_scenario("formation-50"))


def started(scenario: Scenario, **start: object) -> Scenario:
    return replace(scenario, robots=replace(scenario.robots, start=replace(scenario.robots.start, **start)))


def positions(scene: Scene) -> np.ndarray:
    return np.array([robot.position for robot in scene.robots])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_robots_keep_the_start_gap_to_each_other_and_to_walls(swarm: Scenario, seed: int) -> None:
    scene = make_scene(replace(swarm, seed=seed))
    points, radii = positions(scene), np.array([robot.type.coverage_radius_m for robot in scene.robots])
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2) - radii[:, None] - radii[None]
    walls = shapely.union_all([shapely.Polygon(obstacle) for obstacle in scene.obstacles])

    assert gaps[~np.eye(len(points), dtype=bool)].min() >= 0.3 - 1e-9
    assert (shapely.distance(walls, shapely.points(points)) - radii).min() >= 0.3 - 1e-9
    assert np.abs(points).max() <= 45.0


def test_the_seed_alone_decides_where_robots_start(swarm: Scenario) -> None:
    same, other = make_scene(swarm), make_scene(replace(swarm, seed=2))

    assert positions(make_scene(swarm)).tolist() == positions(same).tolist()
    assert positions(other).tolist() != positions(same).tolist()


def test_starts_fill_the_square_evenly(swarm: Scenario) -> None:
    points = np.concatenate([positions(make_scene(replace(swarm, seed=seed))) for seed in range(20)])

    quadrants = np.histogram2d(points[:, 0], points[:, 1], bins=2, range=[[-45, 45], [-45, 45]])[0]
    # 1000 draws: 250 per quadrant, standard deviation below 14.
    assert np.abs(quadrants - 250.0).max() < 60.0


def test_explicit_start_points_are_taken_as_they_are(swarm: Scenario) -> None:
    points = tuple((float(10 * (index % 8) - 40), float(12 * (index // 8) - 42)) for index in range(50))
    scenario = started(replace(swarm, map=replace(swarm.map, obstacles=())), positions_m=points)

    assert positions(make_scene(scenario)).tolist() == [list(point) for point in points]


def test_explicit_start_points_in_a_wall_are_refused(swarm: Scenario) -> None:
    points = tuple((1.8 * index - 45.0, -45.0) for index in range(49))
    block = swarm.map.obstacles[0].vertices_m

    with pytest.raises(ConfigError, match=r"r49 starts at .* in or against obstacle 0"):
        make_scene(started(swarm, positions_m=(*points, (block[0][0] + 2.0, block[0][1] + 2.0))))


def test_explicit_start_points_against_the_edge_are_refused(swarm: Scenario) -> None:
    points = ((49.9, 0.0), *((1.8 * index - 45.0, -45.0) for index in range(49)))

    with pytest.raises(
        ConfigError, match=r"r00 starts at \(49\.9, 0\), outside the arena or against its edge; move it"
    ):
        make_scene(started(swarm, positions_m=points))


def test_the_fence_closes_the_arena_from_outside(swarm: Scenario) -> None:
    fence = shapely.union_all([shapely.Polygon(wall) for wall in walls(swarm)[-4:]])

    assert swarm.map.bounds_m is not None
    assert shapely.Polygon(fence.exterior).contains(shapely.box(*swarm.map.bounds_m))
    assert fence.intersection(shapely.box(*swarm.map.bounds_m)).area == pytest.approx(0.0)
    assert fence.boundary.contains(shapely.box(*swarm.map.bounds_m).boundary)


def test_no_path_leaves_the_arena(swarm: Scenario) -> None:
    # A wall from edge to edge, but for a gap too narrow for any robot: the way around would lead outside.
    barrier = Obstacle(name="barrier", vertices_m=((-1.0, -49.9), (1.0, -49.9), (1.0, 49.9), (-1.0, 49.9)))
    halves = replace(swarm, map=replace(swarm.map, obstacles=(barrier,)))
    planner = planner_for(walls(halves), THESIS_TYPES[2].coverage_radius_m, swarm.agent.planning)

    assert planner.path(np.array([-10.0, 0.0]), np.array([10.0, 0.0])) is None


def test_robots_rally_at_the_mission_computer_unless_told_otherwise(swarm: Scenario) -> None:
    moved = replace(swarm, mission=replace(swarm.mission, position_m=(5.0, -3.0)))
    told = replace(moved, agent=replace(swarm.agent, decision=replace(swarm.agent.decision, rally_point_m=(1.0, 2.0))))

    assert ScenarioActors(moved).agent_config(NodeId(0)).decision.rally_point_m == (5.0, -3.0)
    assert ScenarioActors(told).agent_config(NodeId(0)).decision.rally_point_m == (1.0, 2.0)


def test_priorities_and_energies_reach_their_robots_and_nobody_else(swarm: Scenario) -> None:
    priorities, energies = (1.0,) * 49 + (4.0,), (0.25, *(1.0,) * 49)
    told = ScenarioActors(replace(swarm, robots=replace(swarm.robots, priorities=priorities, energies=energies)))
    configs = [told.agent_config(robot) for robot in told.robots]

    assert [config.decision.weight.priority for config in configs] == list(priorities)
    assert [config.energy.initial for config in configs] == list(energies)


def test_a_swarm_told_nothing_of_priorities_and_energies_has_the_settings_of_all(swarm: Scenario) -> None:
    agent = replace(swarm.agent, energy=replace(swarm.agent.energy, initial=0.5))
    configs = {ScenarioActors(replace(swarm, agent=agent)).agent_config(NodeId(robot)) for robot in range(50)}

    assert [(config.energy.initial, config.decision.weight.priority) for config in configs] == [(0.5, 1.0)]


@pytest.mark.parametrize("name", ["priorities", "energies"])
def test_a_list_that_does_not_fit_the_robots_is_refused(swarm: Scenario, name: str) -> None:
    with pytest.raises(ConfigError, match=f"{name} has 2 numbers for 50 robots"):
        replace(swarm.robots, **{name: (1.0, 1.0)})


@pytest.mark.parametrize(("name", "number"), [("priorities", 0.0), ("energies", 1.5)])
def test_numbers_out_of_range_are_refused(swarm: Scenario, name: str, number: float) -> None:
    with pytest.raises(ConfigError, match=f"{name} must be"):
        replace(swarm.robots, **{name: (1.0,) * 49 + (number,)})


def test_a_square_without_room_names_the_robot_and_the_remedy(swarm: Scenario) -> None:
    with pytest.raises(ConfigError, match=r"no room for r\d+ after \d+ of 50 .* enlarge start.half_side_m"):
        make_scene(started(swarm, half_side_m=2.0))


@pytest.mark.parametrize(("share", "expected"), [(1.0, (17, 17, 16)), (0.15, (3, 3, 2)), (0.0, (0, 0, 0))])
def test_position_sensors_are_spread_over_the_types(
    swarm: Scenario, share: float, expected: tuple[int, int, int]
) -> None:
    scene = make_scene(replace(swarm, robots=replace(swarm.robots, position_sensor_share=share)))

    carrying = tuple(sum(r.has_position_sensor for r in scene.robots if r.type.type == kind) for kind in (1, 2, 3))
    assert carrying == expected


def test_a_start_spec_in_a_scenario_checks_the_number_of_points(swarm: Scenario) -> None:
    with pytest.raises(ConfigError, match="1 points for 50 robots"):
        replace(swarm.robots, start=StartSpec(positions_m=((0.0, 0.0),)))
