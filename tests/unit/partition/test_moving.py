"""Goals on the way from one shape to another."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal
from rosters import FIELD
from scipy.spatial.distance import pdist

from mission_computer.shape import load_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.bridges import split
from swarm_msgs_py.geometry.contour import area_centroid
from swarm_msgs_py.geometry.mesh_quality import mesh_quality
from swarm_msgs_py.geometry.morphing import Morph
from swarm_msgs_py.partition import GoalSet, Method, PartitionConfig, partition
from swarm_msgs_py.partition.moving import KNOT_S, KNOTS_MAX, KNOTS_MIN, REACH, _check_between, knots_for, track
from swarm_msgs_py.partition.ways import Ways
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

MOVING = [Method.BUBBLE_PACKING, Method.VORONOI]
KNOTS = 8
ROUNDING_M = 0.015  # goals are in whole centimeters
START = load_shape("formation_3")


@lru_cache
def goals_of(method: Method, shape: str = "formation_3") -> GoalSet:
    return partition(load_shape(shape), FIELD, config=PartitionConfig(method=method))


def moved(method: Method, target: FloatArray, rotation: float = 0.0, start: str = "formation_3") -> FloatArray:
    morph = Morph(load_shape(start), target, rotation)
    return track(morph, goals_of(method, start), FIELD, (), PartitionConfig(method=method), knots=KNOTS)


@lru_cache
def to_formation_1(method: Method) -> FloatArray:
    return moved(method, load_shape("formation_1"))


def dented() -> FloatArray:
    """Return the start with a bump of 1.5 m on its right, a tenth of the way around."""
    angles = np.arctan2(START[:, 1], START[:, 0])
    bump = 1.5 * np.maximum(0.0, 1.0 - (angles / 0.3) ** 2)
    return START + bump[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


@pytest.mark.parametrize(
    ("seconds", "knots"),
    [(1.0, KNOTS_MIN), (20.0, 8), (35.0, 8), (36.0, 9), (60.0, 13), (61.0, 14), (315.0, KNOTS_MAX)],
)
def test_knots_are_close_enough_to_interpolate(seconds: float, knots: int) -> None:
    assert knots_for(seconds) == knots
    assert seconds / (knots - 1) <= KNOT_S


@pytest.mark.parametrize("seconds", [316.0, 1300.0, 1e6])
def test_a_motion_of_any_length_has_no_more_knots_than_fit_a_plan(seconds: float) -> None:
    assert knots_for(seconds) == KNOTS_MAX


@pytest.mark.parametrize("method", MOVING)
def test_goals_keep_all_gaps_at_every_knot(method: Method) -> None:
    places, goals = to_formation_1(method), goals_of(method)
    morph, gaps = Morph(START, load_shape("formation_1")), PartitionConfig().gaps
    radii = FIELD.radii_of(goals.types)

    assert_array_equal(places[0], goals.positions.round(2))
    for knot, centers in enumerate(places):
        shape = shapely.Polygon(morph.at(knot / (KNOTS - 1)))
        free = shapely.distance(shape.exterior, shapely.points(centers)) - radii
        apart = np.linalg.norm(centers[:, None] - centers, axis=2) - radii[:, None] - radii
        assert shapely.contains_xy(shape, centers[:, 0], centers[:, 1]).all()
        assert free.min() >= gaps.contour_m - ROUNDING_M
        assert apart[np.triu_indices(len(centers), 1)].min() >= gaps.robot_m - ROUNDING_M


@pytest.mark.parametrize("method", MOVING)
def test_the_mesh_in_the_end_is_nearly_as_regular_as_a_fresh_one(method: Method) -> None:
    target = load_shape("formation_1")
    radii = FIELD.radii_of(goals_of(method).types)

    quality = mesh_quality(to_formation_1(method)[-1], radii, target)
    fresh = mesh_quality(goals_of(method, "formation_1").positions, radii, target)

    assert quality.topological is not None
    assert fresh.topological is not None
    assert quality.topological <= fresh.topological + 0.15
    assert quality.geometrical is not None
    assert quality.geometrical <= 0.025  # the target for a fresh partition
    assert quality.area_variation is not None
    assert quality.area_variation <= 0.2


@pytest.mark.parametrize("method", MOVING)
def test_goals_do_not_jump(method: Method) -> None:
    steps = np.linalg.norm(np.diff(to_formation_1(method), axis=0), axis=2)

    # The contour's own fastest point goes about 14 m, 1.5 times as fast as the mean in the middle.
    assert steps.max() < 14.0 * 1.5 / (KNOTS - 1)


@pytest.mark.parametrize("method", MOVING)
def test_equal_inputs_give_equal_tracks(method: Method) -> None:
    target = START + np.array([3.0, 1.0])

    assert_array_equal(moved(method, target), moved(method, target.copy()))


@pytest.mark.parametrize("method", MOVING)
def test_a_translation_moves_all_goals_alike(method: Method) -> None:
    places = moved(method, START + np.array([8.0, -3.0]))

    assert_allclose(places[-1] - places[0], np.tile([8.0, -3.0], (50, 1)), atol=0.021)
    spread = np.ptp(places - places[:1], axis=1)
    assert spread.max() <= 0.021  # the same way for all, in whole centimeters


@pytest.mark.parametrize("method", MOVING)
def test_a_turn_takes_the_goals_around(method: Method) -> None:
    center = area_centroid(START)
    places = moved(method, center + (START - center) @ np.array([[0.0, 1.0], [-1.0, 0.0]]), np.pi / 2.0)

    arms = places - center
    assert_allclose(arms[-1], np.column_stack([-arms[0, :, 1], arms[0, :, 0]]), atol=0.1)
    assert np.ptp(np.linalg.norm(arms, axis=2), axis=0).max() < 0.1  # on circles, not straight through


@pytest.mark.parametrize("method", MOVING)
@pytest.mark.parametrize("degrees", [350.0, 360.0, 720.0])
def test_all_the_way_around_neighbors_stay_neighbors(method: Method, degrees: float) -> None:
    bar, angle = np.array([[-8.0, -2.0], [8.0, -2.0], [8.0, 2.0], [-8.0, 2.0]]), np.radians(degrees)
    roster, config = Roster.of(list(THESIS_TYPES[:1]) * 9), PartitionConfig(method=method)
    goals = partition(bar, roster, config=config)
    target = (bar @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])).round(2)
    morph = Morph(bar, target, angle)

    places = track(morph, goals, roster, (), config, knots=KNOTS)

    ways = Ways(places, morph.centers, angle)
    near, far = pdist(places[0]).min(), pdist(places[0]).max()
    for share in np.linspace(0.0, 1.0, 50):
        between = pdist(ways.goals(share))
        assert between.min() > 0.9 * near
        assert between.max() < 1.1 * far
    assert np.linalg.norm(ways.goals(0.3) - places[0], axis=1).max() > 5.0


def test_goals_that_meet_half_way_between_knots_are_refused() -> None:
    morph = Morph(START, START + 1.0)
    apart, radii = np.array([[-1.0, 0.0], [1.0, 0.0]]), np.array([0.4, 0.4])

    _check_between(np.stack([apart, apart + 1.0, apart + 1.0]), morph, radii)
    with pytest.raises(ShapeError, match=r"after 75 % of its motion goals .* give it more time"):
        _check_between(np.stack([apart, apart, apart[::-1]]), morph, radii)


@pytest.mark.parametrize("method", MOVING)
def test_growth_spreads_the_goals(method: Method) -> None:
    places, center = moved(method, 1.2 * START), area_centroid(START)

    grown = 1.2 * center + 1.2 * (places[0] - center)
    assert np.linalg.norm(places[-1] - grown, axis=1).max() < 0.5


@pytest.mark.parametrize("method", MOVING)
def test_goals_far_from_a_change_stay_exactly_where_they_are(method: Method) -> None:
    places = moved(method, dented())

    ways = np.abs(places - places[0]).max(axis=(0, 2))
    far = places[0][:, 0] < 9.0 - (REACH + 1.0) * 2.7  # hexagonal spacing of 50 robots on 300 m2: 2.6 m
    assert far.sum() >= 15
    assert ways[far].max() == 0.0
    assert ways.max() > 0.2


@pytest.mark.parametrize("method", MOVING)
def test_a_shape_that_hardly_changes_leaves_the_goals_at_rest(method: Method) -> None:
    target = START.copy()
    target[10] += 0.02

    ways = np.abs(moved(method, target) - goals_of(method).positions.round(2)).max(axis=(0, 2))
    assert (ways == 0.0).sum() >= 48
    assert ways.max() <= 0.1


@pytest.mark.parametrize("method", MOVING)
def test_both_parts_of_a_split_get_about_half_of_the_goals_and_none_is_left_between(method: Method) -> None:
    target = split(START, 0.0, 6.0)
    centers = moved(method, target)[-1]

    left, right = (centers[:, 0] < -3.0), (centers[:, 0] > 2.0)
    assert (left | right).all()
    assert abs(int(left.sum()) - 25) <= 3


def test_goals_stay_clear_of_obstacles_that_the_shape_moves_over() -> None:
    obstacle = np.array([[15.0, -1.0], [17.0, -1.0], [17.0, 1.0], [15.0, 1.0]])
    goals, config = goals_of(Method.BUBBLE_PACKING), PartitionConfig()
    morph = Morph(START, START + np.array([14.0, 0.0]))

    places = track(morph, goals, FIELD, (obstacle,), config, knots=KNOTS)

    radii = FIELD.radii_of(goals.types)
    for centers in places:
        free = shapely.distance(shapely.Polygon(obstacle), shapely.points(centers)) - radii
        assert free.min() >= config.gaps.obstacle_m - ROUNDING_M


def test_a_method_that_draws_anew_cannot_move_goals() -> None:
    config = PartitionConfig(method=Method.FRACTALS)

    with pytest.raises(ShapeError, match="fractals is not applicable to moving shapes; use bubble-packing or voronoi"):
        track(Morph(START, 1.1 * START), goals_of(Method.VORONOI), FIELD, (), config, knots=KNOTS)


@pytest.mark.parametrize("method", MOVING)
@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_a_few_robots_can_move_as_well(method: Method, count: int) -> None:
    roster, config = Roster.of(list(THESIS_TYPES[:1]) * count), PartitionConfig(method=method)
    start = START / 4.0
    goals = partition(start, roster, config=config)

    places = track(Morph(start, 1.2 * start + 5.0), goals, roster, (), config, knots=KNOTS)

    shape = shapely.Polygon(1.2 * start + 5.0)
    assert shapely.contains_xy(shape, places[-1, :, 0], places[-1, :, 1]).all()


def test_where_the_shape_becomes_too_small_is_told() -> None:
    with pytest.raises(ShapeError, match=r"after \d+ % of its motion the shape has no room"):
        moved(Method.VORONOI, 0.2 * START)


def test_gaps_of_nothing_cannot_become_less_than_nothing() -> None:
    gaps = replace(PartitionConfig().gaps, robot_m=0.01, contour_m=0.01)
    config = PartitionConfig(gaps=gaps)
    goals = goals_of(Method.BUBBLE_PACKING)

    places = track(Morph(START, START + 1.0), goals, FIELD, (), config, knots=KNOTS)

    assert_allclose(places[-1] - places[0], 1.0, atol=0.021)
