from __future__ import annotations

import math

import numpy as np
import pytest

from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.configuration_space import disc_polygon
from swarm_agent.planning.path_planner import PathPlanner, lower_bound_planner, planner_for
from swarm_agent.planning.shortest_path import ShortestPaths

CONFIG = PlanningConfig()
WALL = np.array([(-1.0, -4.0), (1.0, -4.0), (1.0, 4.0), (-1.0, 4.0)])
ROOM = tuple(
    np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], dtype=float)
    for x0, y0, x1, y1 in [(-5, -5, 5, -4), (-5, 4, 5, 5), (-5, -5, -4, 5), (4, -5, 5, 5)]
)


def test_without_obstacles_every_cost_is_the_distance():
    planner = planner_for((), 0.3, CONFIG)
    assert planner.costs(np.zeros(2), np.array([(3.0, 4.0), (0.0, 0.0)])).tolist() == [5.0, 0.0]
    assert planner.path(np.zeros(2), np.array([3.0, 4.0])).tolist() == [[3.0, 4.0]]
    assert planner.is_clear(np.zeros(2), np.array([3.0, 4.0]))


def test_a_wall_costs_the_way_around_its_rounded_end():
    planner = planner_for((WALL,), 0.4, PlanningConfig(polygon_sides=256))
    # A taut string over arcs of radius 0.5 about the corners (+-1, 4): straight, arc, 2 m flat, arc, straight.
    start, goal = np.array([-5.0, 0.0]), np.array([5.0, 0.0])
    away = math.hypot(4.0, 4.0)
    leave = math.atan2(4.0, 4.0) + math.asin(0.5 / away)  # heading of the first straight leg
    expected = 2.0 * (math.sqrt(away**2 - 0.25) + 0.5 * leave) + 2.0
    assert planner.costs(start, goal[None])[0] == pytest.approx(expected, rel=1e-4)
    assert planner.costs(start, goal[None])[0] >= expected


def test_way_points_lead_around_the_nearer_end_of_a_wall():
    path = planner_for((WALL,), 0.4, CONFIG).path(np.array([-5.0, 1.0]), np.array([5.0, 1.0]))
    assert (path[:-1, 1] > 4.0).all()
    assert np.all(np.diff(path[:, 0]) > 0.0)


def test_sliding_along_a_grown_wall_is_clear_and_costs_the_distance():
    planner = planner_for((WALL,), 0.4, CONFIG)
    one, two = np.array([-1.5, -9.0]), np.array([-1.5, 9.0])
    assert planner.is_clear(one, two)
    assert planner.costs(one, two[None])[0] == 18.0
    assert not planner.is_clear(one + np.array((0.001, 0.0)), two + np.array((0.001, 0.0)))


def test_from_corner_to_corner_along_the_outline_every_edge_is_clear():
    planner = planner_for((WALL,), 0.4, CONFIG)
    ring = planner.space.rings[0]
    assert all(planner.is_clear(one, two) for one, two in zip(ring, np.roll(ring, -1, axis=0), strict=True))
    assert not any(planner.is_clear(one, two) for one, two in zip(ring, np.roll(ring, -2, axis=0), strict=True))


def test_a_goal_inside_a_margin_cannot_be_reached_but_its_neighbor_can():
    planner = planner_for((WALL,), 0.4, CONFIG)
    start = np.array([-5.0, 0.0])
    costs = planner.costs(start, np.array([(-1.4, 0.0), (-1.6, 0.0), (0.0, 0.0)]))
    assert costs.tolist() == [math.inf, pytest.approx(3.4), math.inf]
    assert planner.path(start, np.array([-1.4, 0.0])) is None


def test_a_walled_off_goal_costs_infinity_in_both_directions():
    planner = planner_for(ROOM, 0.3, CONFIG)
    inside, outside = np.zeros(2), np.array([9.0, 0.0])
    assert planner.costs(inside, outside[None])[0] == math.inf
    assert planner.costs(outside, inside[None])[0] == math.inf
    assert planner.path(outside, inside) is None
    assert planner.costs(inside, np.array([(3.0, 3.0)]))[0] == pytest.approx(math.hypot(3.0, 3.0))


def test_a_gap_is_passed_by_the_small_robot_and_closed_for_the_large_one():
    doors = (np.array([(-1.0, 0.5), (1.0, 0.5), (1.0, 9.0), (-1.0, 9.0)]),)
    doors += (doors[0] * (1.0, -1.0),)
    start, goal = np.array([-5.0, 0.0]), np.array([5.0, 0.0])
    assert planner_for(doors, 0.3, CONFIG).costs(start, goal[None])[0] == 10.0
    assert planner_for(doors, 0.5, CONFIG).costs(start, goal[None])[0] > 18.0


def test_a_start_in_the_margin_leaves_it_without_a_stop():
    planner = planner_for((WALL,), 0.4, CONFIG)
    start, goal = np.array([-1.45, 0.0]), np.array([-6.0, 0.5])
    assert planner.is_clear(start, goal)
    assert planner.path(start, goal).tolist() == [goal.tolist()]
    assert planner.costs(start, goal[None])[0] == pytest.approx(np.linalg.norm(goal - start))
    assert not planner.is_clear(start, np.array([5.0, 0.0]))
    across = planner.path(start, np.array([5.0, 0.0]))
    assert len(across) > 2
    assert np.abs(across[0]).max() > 4.0


def test_a_start_on_a_corner_does_not_repeat_it_as_a_way_point():
    planner = planner_for((WALL,), 0.4, CONFIG)
    corner = planner.graph.nodes[np.argmax(planner.graph.nodes @ (-1.0, 0.2))]
    path = planner.path(corner, np.array([5.0, 0.0]))
    assert np.linalg.norm(path[0] - corner) > 0.01


def test_equal_obstacles_share_one_planner_and_changed_ones_do_not():
    planner = planner_for((WALL,), 0.4, CONFIG)
    assert planner_for((WALL.copy(),), 0.4, PlanningConfig()) is planner
    assert planner_for((WALL + 1.0,), 0.4, CONFIG) is not planner
    assert planner_for((WALL,), 0.5, CONFIG) is not planner
    assert planner_for((WALL,), 0.4, PlanningConfig(clearance_margin_m=0.2)) is not planner
    assert lower_bound_planner((WALL,), 0.4) is not planner


def test_the_goal_side_of_the_work_is_done_once_for_all_robots(monkeypatch):
    asked = []
    original = ShortestPaths.to_goals
    monkeypatch.setattr(ShortestPaths, "to_goals", lambda self, goals: asked.append(1) or original(self, goals))
    planner, goals = planner_for((WALL,), 0.77, CONFIG), np.array([(5.0, 0.0), (4.0, 1.0)])
    costs = [planner.costs(np.array([-5.0, y]), goals.copy()).tolist() for y in (-1.0, 0.0, 1.0)]
    assert len(asked) == 1
    assert costs[0] != costs[1]


def test_no_goals_cost_nothing_to_ask():
    assert planner_for((WALL,), 0.4, CONFIG).costs(np.array([-5.0, 0.0]), np.empty((0, 2))).shape == (0,)


def test_the_bound_lies_between_the_distance_and_every_planned_path():
    start, goal = np.array([-5.0, 0.0]), np.array([5.0, 0.0])
    bound = lower_bound_planner((WALL,), 0.4).costs(start, goal[None])[0]
    away, leave = math.hypot(4.0, 4.0), math.atan2(4.0, 4.0) + math.asin(0.4 / math.hypot(4.0, 4.0))
    exact = 2.0 * (math.sqrt(away**2 - 0.16) + 0.4 * leave) + 2.0  # of a disc that touches the wall
    assert exact - 0.01 < bound < exact
    assert exact < planner_for((WALL,), 0.4, CONFIG).costs(start, goal[None])[0]


def test_equal_questions_get_the_same_bytes():
    rng = np.random.default_rng(3)
    starts, goals = rng.uniform(-8.0, 8.0, (20, 2)), rng.uniform(-8.0, 8.0, (6, 2))
    runs = [
        [planner.costs(start, goals).tobytes() for start in starts]
        for planner in (PathPlanner((WALL, *ROOM), disc_polygon(0.3, 16)) for _ in range(2))
    ]
    assert runs[0] == runs[1]
