"""What must hold for every scene, start and goal."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles_planning import (
    TOUCH,
    brute_force_cost,
    grown_by_triangles,
    points,
    polyline_length,
    regular_polygon_around,
    scenes,
)
from shapely.geometry import LineString, Point

from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import PathPlanner, lower_bound_planner, planner_for

CONFIG = PlanningConfig()
NEAR = 1e-4  # how far two descriptions of the same path may differ, for cuts of TOUCH at each corner [m]
radii = st.sampled_from([0.15, 0.3, 0.5, 1.0])


def free_points(planner: PathPlanner, *candidates: np.ndarray) -> bool:
    """Whether all points are clearly free, so that rounding cannot decide the test."""
    return all(planner.space.forbidden.distance(Point(point)) > NEAR for point in candidates)


@given(scenes(), radii)
def test_the_forbidden_space_is_the_minkowski_sum_with_the_circumscribed_polygon(obstacles, radius):
    planner = planner_for(obstacles, radius, CONFIG)
    expected = grown_by_triangles(obstacles, regular_polygon_around(radius + 0.1, 16))
    assert shapely.symmetric_difference(planner.space.forbidden, expected).area < 1e-5


@settings(max_examples=40)
@given(scenes(4), radii, points(), points())
def test_the_cost_is_the_length_over_the_complete_visibility_graph(obstacles, radius, start, goal):
    planner = planner_for(obstacles, radius, CONFIG)
    assume(free_points(planner, start))
    slow = brute_force_cost(planner.space.forbidden, start, goal)
    assert planner.costs(start, goal[None])[0] == pytest.approx(slow, abs=NEAR)


@given(scenes(), radii, points(), points())
def test_a_path_is_as_long_as_its_cost_and_stays_in_free_space(obstacles, radius, start, goal):
    planner = planner_for(obstacles, radius, CONFIG)
    assume(free_points(planner, start))
    cost, path = planner.costs(start, goal[None])[0], planner.path(start, goal)
    assert (path is None) == math.isinf(cost)
    if path is None:
        return
    whole = np.vstack((start, path))
    assert np.array_equal(path[-1], goal)
    assert polyline_length(whole) == pytest.approx(cost, rel=1e-9)
    assert cost >= np.linalg.norm(goal - start) - 1e-9
    assert not LineString(whole).intersects(planner.space.forbidden.buffer(-3.0 * TOUCH))


@given(scenes(), radii, points(), points())
def test_every_leg_of_a_path_is_clear_by_itself(obstacles, radius, start, goal):
    planner = planner_for(obstacles, radius, CONFIG)
    assume(free_points(planner, start))
    path = planner.path(start, goal)
    assume(path is not None)
    whole = np.vstack((start, path))
    assert all(planner.is_clear(one, two) for one, two in itertools.pairwise(whole))


@given(scenes(), radii, points(), points())
def test_there_costs_what_back_costs(obstacles, radius, one, two):
    planner = planner_for(obstacles, radius, CONFIG)
    assume(free_points(planner, one, two))
    assert planner.costs(one, two[None])[0] == pytest.approx(planner.costs(two, one[None])[0], abs=NEAR)


@given(scenes(), radii, points(), points(), points())
def test_a_detour_never_saves_way(obstacles, radius, start, between, goal):
    planner = planner_for(obstacles, radius, CONFIG)
    assume(free_points(planner, start, between, goal))
    direct, first = planner.costs(start, np.stack((goal, between)))
    assert direct <= first + planner.costs(between, goal[None])[0] + NEAR


@given(scenes(), radii, points(), st.lists(points(), min_size=1, max_size=6))
def test_many_goals_at_once_cost_what_each_costs_alone(obstacles, radius, start, goals):
    planner = planner_for(obstacles, radius, CONFIG)
    together = planner.costs(start, np.array(goals))
    assert together.tolist() == pytest.approx([planner.costs(start, goal[None])[0] for goal in goals], rel=1e-12)


@given(scenes(), radii, points(), points())
def test_a_segment_is_clear_exactly_if_it_misses_the_forbidden_space(obstacles, radius, start, end):
    planner = planner_for(obstacles, radius, CONFIG)
    forbidden, segment = planner.space.forbidden, LineString((start, end))
    assume(free_points(planner, start))
    if forbidden.distance(segment) > NEAR:
        assert planner.is_clear(start, end)
    if forbidden.buffer(-NEAR).intersects(segment):
        assert not planner.is_clear(start, end)


@given(scenes(), radii, points())
def test_a_point_is_free_exactly_if_no_grown_obstacle_holds_it(obstacles, radius, point):
    space = planner_for(obstacles, radius, CONFIG).space
    assume(space.forbidden.boundary.distance(Point(point)) > NEAR or space.forbidden.is_empty)
    assert space.is_free(point) == (not space.forbidden.contains(Point(point)))


@given(scenes(), radii, points())
def test_a_projected_point_is_free_and_the_nearest_free_one(obstacles, radius, point):
    space = planner_for(obstacles, radius, CONFIG).space
    projected = space.project(point)
    assert space.is_free(projected)
    if space.forbidden.contains(Point(point)):
        nearest = space.forbidden.boundary.distance(Point(point))
        assert np.linalg.norm(projected - point) == pytest.approx(nearest, abs=2.0 * TOUCH)
    else:
        assert np.array_equal(projected, point)


@given(scenes().filter(len), radii, st.floats(0.0, 0.99), st.floats(0.0, math.tau), points())
def test_the_leg_out_of_a_margin_never_leads_deeper_into_it(obstacles, radius, share, angle, goal):
    planner = planner_for(obstacles, radius, CONFIG)
    forbidden = planner.space.forbidden
    start = obstacles[0][0] + share * (radius + 0.1) * np.array([math.cos(angle), math.sin(angle)])
    path = planner.path(start, goal)
    assume(path is not None)
    deepest = forbidden.boundary.distance(Point(start))
    for done in np.linspace(0.0, 1.0, 30):
        point = Point(start + done * (path[0] - start))
        depth = forbidden.boundary.distance(point) if forbidden.contains(point) else 0.0
        assert depth <= (1.0 - done) * deepest + NEAR


@given(scenes(), radii, points(), points())
def test_no_path_beats_the_lower_bound(obstacles, radius, start, goal):
    planner, bound = planner_for(obstacles, radius, CONFIG), lower_bound_planner(obstacles, radius)
    assume(free_points(planner, start))
    assert bound.costs(start, goal[None])[0] <= planner.costs(start, goal[None])[0]
