"""Home: where the spec says, inside the shape, and with room for each of those that return."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely
from builders import PERIOD, make_plan, make_presence
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from mission_computer.shape.library import library_points
from swarm_agent.decision.homing import HOME_PERIOD_S, INSIDE_M, Home, home_destination, home_point
from swarm_agent.planning.configuration_space import ConfigurationSpace, disc_polygon
from swarm_msgs_py.messages.bodies import Motion
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray, NodeId

ARC_ERROR = 0.002  # [m]; round corners of an inset are polygons
HORSESHOE = np.array([[0, 0], [12, 0], [12, 3], [3, 3], [3, 9], [12, 9], [12, 12], [0, 12]], dtype=float)
SPACING = 3.0
HOME = np.array([1.0, -2.0])


def depth(contour: FloatArray, point: FloatArray) -> float:
    """Return how far inside the contour a point lies, negative outside [m]."""
    shape, where = shapely.Polygon(contour), shapely.Point(point)
    distance = float(shape.exterior.distance(where))
    return distance if shape.contains(where) else -distance


def boundary_center(contour: FloatArray) -> FloatArray:
    """Return thesis eq. (3.65): the mean of the contour by length."""
    after = np.roll(contour, -1, axis=0)
    lengths = np.hypot(*(after - contour).T)
    return np.asarray(((contour + after) / 2.0 * lengths[:, None]).sum(axis=0) / lengths.sum())


def test_in_a_convex_shape_home_is_the_center_of_the_boundary_and_not_of_the_area() -> None:
    wedge = np.array([[0, 0], [20, -4], [20, 4]], dtype=float)

    assert_allclose(home_point(wedge), boundary_center(wedge), atol=1e-9)
    assert np.linalg.norm(home_point(wedge) - wedge.mean(axis=0)) > 0.1


def test_where_the_center_lies_outside_home_is_the_nearest_point_well_inside() -> None:
    assert depth(HORSESHOE, boundary_center(HORSESHOE)) < 0.0

    home = home_point(HORSESHOE)

    assert depth(HORSESHOE, home) == pytest.approx(INSIDE_M, abs=ARC_ERROR)
    grid = np.stack(np.meshgrid(np.linspace(0, 12, 121), np.linspace(0, 12, 121)), axis=-1).reshape(-1, 2)
    inside = [point for point in grid if depth(HORSESHOE, point) >= INSIDE_M]
    nearest = min(float(np.linalg.norm(point - boundary_center(HORSESHOE))) for point in inside)
    assert np.linalg.norm(home - boundary_center(HORSESHOE)) <= nearest + ARC_ERROR


def test_a_center_too_close_to_the_edge_moves_inward_to_the_margin() -> None:
    notched = np.array([[-10, -3], [10, -3], [10, 3], [0.5, 3], [0.0, 0.2], [-0.5, 3], [-10, 3]], dtype=float)
    assert 0.0 < abs(depth(notched, boundary_center(notched))) < INSIDE_M

    assert depth(notched, home_point(notched)) == pytest.approx(INSIDE_M, abs=ARC_ERROR)


@pytest.mark.parametrize("width", [1.9, 0.4, 0.01])
def test_in_a_shape_thinner_than_the_margin_home_is_still_inside(width: float) -> None:
    strip = np.array([[0, 0], [9, 0], [9, width], [0, width]])

    assert_allclose(home_point(strip), [4.5, width / 2.0], atol=0.3 * width)
    assert depth(strip, home_point(strip)) > 0.1 * width


DISC = disc_polygon(0.5, 16)
PLATE = np.array([[-6, -4], [6, -4], [6, 4], [-6, 4]], dtype=float)  # its center is the origin


def square(x: float, y: float, half: float) -> FloatArray:
    return np.array([x, y]) + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)


@pytest.mark.parametrize(
    "obstacles",
    [
        (square(0.0, 0.0, 0.3),),
        (square(0.7, 0.0, 0.3),),
        (square(0.0, 0.5, 0.3), square(-1.0, 0.0, 0.6)),
        (square(0.0, 0.0, 2.8),),
        (square(0.0, 9.0, 10.0),),
    ],
)
def test_where_home_is_taken_it_is_the_nearest_free_point_inside(obstacles: tuple[FloatArray, ...]) -> None:
    space = ConfigurationSpace(obstacles, DISC)
    assert not space.is_free(home_point(PLATE))

    home = home_point(PLATE, space)

    assert space.is_free(home)
    margin = min(depth(PLATE, home), INSIDE_M)
    assert margin > 0.2
    grid = np.stack(np.meshgrid(np.linspace(-6, 6, 121), np.linspace(-4, 4, 81)), axis=-1).reshape(-1, 2)
    distances = [np.hypot(*point) for point in grid if depth(PLATE, point) >= margin - 1e-9 and space.is_free(point)]
    assert np.hypot(*home) <= min(distances) + 0.02


def test_an_obstacle_beside_home_leaves_it_where_it_is() -> None:
    space = ConfigurationSpace((square(3.0, 0.0, 1.0),), DISC)

    assert_allclose(home_point(PLATE, space), home_point(PLATE))


@pytest.mark.parametrize("contour", [PLATE, PLATE[:2], np.empty((0, 2))], ids=["shape", "segment", "no corner"])
def test_where_nothing_inside_is_free_home_is_the_nearest_free_point_outside(contour: FloatArray) -> None:
    space = ConfigurationSpace((square(0.0, 0.0, 9.0),), DISC)

    home = home_point(contour, space)

    assert space.is_free(home)
    assert np.abs(home).max() == pytest.approx(9.5)


# Field `home_point` of the shapes' data sheets; made apart from this code.
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("formation_1", [-4.2123, 2.8033]),
        ("formation_2", [4.8919, -7.3053]),
        ("formation_3", [0.007, 0.0015]),
        ("formation_4", [5.7237, 5.0453]),
        ("hw_1_trapezoid", [0.0, -0.0669]),
        ("hw_2_square", [0.0, 0.0]),
        ("hw_3_pentagon", [0.0, 0.0]),
        ("hw_4_arrow", [0.0262, 0.0]),
        ("hw_5_line", [0.0, 0.0]),
        ("iso_1_circle", [0.0, 0.0]),
        ("iso_2_rect", [0.0, 0.0]),
        ("iso_3_rect", [0.0, 0.0]),
        ("iso_4_free", [0.5152, -0.1407]),
    ],
)
def test_homes_of_the_library_are_those_of_its_data_sheets(name: str, expected: list[float]) -> None:
    assert_allclose(home_point(library_points(name)), expected, atol=0.02)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(3, 12), st.integers(0, 10_000))
def test_home_is_inside_any_star_shaped_contour(corners: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    shift = np.array([30.0, -7.0])
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, corners))
    contour = rng.uniform(0.5, 20.0, corners)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    if not shapely.Polygon(contour).is_valid or shapely.Polygon(contour).area < 1e-3:
        return

    assert depth(contour, home_point(contour)) > 0.0
    assert_allclose(home_point(contour + shift), home_point(contour) + shift, atol=1e-6)


@pytest.mark.parametrize(
    "forged",
    [
        np.empty((0, 2)),
        np.array([[3.0, 4.0]]),
        np.array([[0.0, 0.0], [2.0, 0.0]]),
        np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]]),
        np.full((5, 2), 7.0),
        np.array([[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]),
    ],
    ids=["no corner", "point", "segment", "flat", "five times one corner", "bow tie"],
)
def test_a_contour_that_is_none_gives_some_point_of_it_and_no_crash(forged: FloatArray) -> None:
    home = home_point(forged)

    assert home.shape == (2,)
    assert np.isfinite(home).all()
    if len(forged):
        assert (home >= forged.min(axis=0)).all()
        assert (home <= forged.max(axis=0)).all()


def returning(x: float, y: float) -> Presence:
    return make_presence(x, y, mode=int(Mode.RETURN_HOME), is_beacon=False)


def destination(
    robot: int, position: tuple[float, float], neighbors: dict[int, Presence], spacing: float = SPACING
) -> FloatArray | None:
    pairs = [(NodeId(n), presence) for n, presence in neighbors.items()]
    return home_destination(NodeId(robot), np.array(position), HOME, pairs, spacing)


def test_alone_a_robot_drives_home() -> None:
    assert destination(3, (9.0, 9.0), {}) is HOME


def test_who_is_nearer_goes_on_and_who_is_behind_stops_at_the_spacing() -> None:
    assert destination(3, (3.9, -2.0), {4: returning(1.0, -2.0)}) is None
    assert destination(3, (4.1, -2.0), {4: returning(1.0, -2.0)}) is HOME
    assert destination(4, (1.0, -2.0), {3: returning(3.9, -2.0)}) is HOME


def test_who_returns_and_asks_for_way_is_still_one_that_returns() -> None:
    held_up = replace(returning(1.0, -2.0), asks_for_way=True)

    assert destination(3, (3.9, -2.0), {4: held_up}) is None


def test_of_two_at_the_same_distance_the_lower_address_goes_on() -> None:
    assert destination(3, (2.0, -2.0), {4: returning(0.0, -2.0)}) is HOME
    assert destination(4, (0.0, -2.0), {3: returning(2.0, -2.0)}) is None


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode is not Mode.RETURN_HOME])
def test_robots_that_have_a_place_in_the_shape_are_no_reason_to_stop(mode: Mode) -> None:
    assert destination(3, (2.0, -2.0), {4: make_presence(1.0, -2.0, mode=int(mode))}) is HOME


def test_returned_robots_settle_three_meters_apart_around_home() -> None:
    positions = {n: np.random.default_rng(n).uniform(-20.0, 20.0, 2) for n in range(8)}
    for _ in range(400):
        told = {n: returning(*point) for n, point in positions.items()}
        for n, position in list(positions.items()):
            others = {m: presence for m, presence in told.items() if m != n}
            target = destination(n, (position[0], position[1]), others)
            if target is not None:
                away = target - position
                positions[n] = position + away * min(1.0, 0.2 / max(float(np.hypot(*away)), 1e-9))

    points = np.array(list(positions.values()))
    gaps = np.linalg.norm(points[:, None] - points[None], axis=2)[np.triu_indices(8, 1)]
    assert np.linalg.norm(points - HOME, axis=1).min() < 1e-6
    assert np.linalg.norm(points - HOME, axis=1).max() < 4.0 * SPACING
    assert gaps.min() > SPACING - 0.45  # both may move 0.2 m in the last step


def test_home_moves_along_with_the_shape_and_is_looked_for_anew_now_and_then() -> None:
    home, space = Home(PERIOD), ConfigurationSpace((), 0.3)
    square = np.array([[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]])
    still = replace(make_plan(np.zeros((1, 2))), contour=square)
    east = np.array([20.0, 0.0])
    motion = Motion(40, 80, square, 0.0, np.zeros((1, 1, 2)), 9)
    moving = replace(still, epoch=2, contour=square + east, motion=motion, follows=1)
    home.learn(0, still)
    assert_allclose(home.point(0, still, space), [0.0, 0.0], atol=1e-9)
    home.learn(30, moving)

    points = {tick: home.point(tick, moving, space) for tick in range(30, 140)}

    assert_allclose(points[39], [0.0, 0.0], atol=1e-9)
    assert_allclose(points[80], [10.0, 0.0], atol=0.01)
    assert_allclose(points[120], east, atol=1e-9)
    assert_allclose(points[139], east, atol=1e-9)
    changes = [tick for tick in range(31, 140) if not np.array_equal(points[tick], points[tick - 1])]
    assert changes == list(range(40 + round(HOME_PERIOD_S / PERIOD), 121, round(HOME_PERIOD_S / PERIOD)))


def test_a_motion_that_cannot_be_leads_home_to_where_it_would_end() -> None:
    home, space = Home(PERIOD), ConfigurationSpace((), 0.3)
    bowtie = np.array([[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]])
    plan = make_plan(np.zeros((1, 2)))
    forged = replace(plan, motion=Motion(2, 20, bowtie, 0.0, np.zeros((1, 1, 2)), 5))
    home.learn(0, forged)

    assert_allclose(home.point(10, forged, space), home_point(plan.contour, space))
