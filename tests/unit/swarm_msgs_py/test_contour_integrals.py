import numpy as np
import pytest
import shapely
from numpy.testing import assert_allclose, assert_array_equal
from oracles_contour import summed_attraction, summed_repulsion, summed_transition, summed_winding_number

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.contour import boundary_center
from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals
from swarm_msgs_py.types import FloatArray

SQUARE = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
WIDE = np.array([[-1000.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0], [-1000.0, 1000.0]])
SPACING = 0.01  # dz of the thesis


def around(contour: FloatArray) -> FloatArray:
    """Return points inside and outside of a contour, none of them nearer to it than a tenth of its size."""
    center, reach = contour.mean(axis=0), np.linalg.norm(np.ptp(contour, axis=0))
    points = center + reach * np.random.default_rng(3).uniform(-1.0, 1.0, (60, 2))
    clear = shapely.distance(shapely.LinearRing(contour), shapely.points(points)) > 0.1 * reach
    return points[clear]


@pytest.mark.parametrize("name", ["formation_1", "formation_2", "hw_4_arrow"])
def test_the_closed_forms_are_the_limits_of_the_thesis_sums(name: str) -> None:
    contour = load_shape(name)
    points, spacing = around(contour), np.linalg.norm(np.ptp(contour, axis=0)) / 5000
    at = ContourIntegrals(contour).at(points)

    for integral, summed in (
        (at.attraction, summed_attraction),
        (at.repulsion, summed_repulsion),
        (at.transition, summed_transition),
    ):
        expected = np.array([summed(contour, point, spacing) for point in points])
        assert_allclose(integral, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(("distance_in_spacings", "error"), [(1.0, 0.01), (1.5, 0.001)])
def test_the_thesis_sums_err_by_a_percent_one_spacing_from_the_contour(
    distance_in_spacings: float, error: float
) -> None:
    # The worst places lie between two samples and over one; the first sample is half a spacing from the corner.
    height = distance_in_spacings * SPACING
    points = np.array([[2.0, height], [2.0 + 0.5 * SPACING, height]])

    exact = ContourIntegrals(SQUARE).at(points).repulsion[:, 1]
    summed = np.array([summed_repulsion(SQUARE, point, SPACING)[1] for point in points])

    assert np.abs(summed / exact - 1.0).max() < 1.5 * error
    assert np.abs(summed / exact - 1.0).max() > 0.1 * error


def test_nearer_than_that_the_thesis_sums_are_wrong() -> None:
    points = np.array([[2.0, 0.2 * SPACING], [2.0 + 0.5 * SPACING, 0.2 * SPACING]])

    exact = ContourIntegrals(SQUARE).at(points).repulsion[:, 1]
    summed = np.array([summed_repulsion(SQUARE, point, SPACING)[1] for point in points])

    assert np.abs(summed / exact - 1.0).max() > 0.5


@pytest.mark.parametrize("name", ["formation_2", "formation_4"])
def test_inside_agrees_with_the_winding_number_of_the_thesis(name: str) -> None:
    contour = load_shape(name)
    points = around(contour)

    winding = np.array([summed_winding_number(contour, point, SPACING) for point in points])

    assert_array_equal(ContourIntegrals(contour).at(points).inside, winding > 0.5)


def test_a_ray_through_corners_and_along_edges_counts_right() -> None:
    saw = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [5.0, 1.0], [4.0, 2.0], [3.0, 1.0], [2.0, 2.0], [0.0, 2.0]])
    points = np.array([[1.0, 1.0], [2.9, 1.1], [3.0, 1.1], [-1.0, 1.0], [-1.0, 2.0], [-1.0, 0.0], [4.0, 1.5]])

    inside = ContourIntegrals(saw).at(points).inside

    assert_array_equal(inside, [True, False, False, False, False, False, True])


def test_signed_distances_are_those_of_the_nearest_edge_or_corner() -> None:
    points = np.array([[2.0, 1.0], [2.0, -1.0], [-3.0, -4.0], [4.0, 2.0], [3.5, 0.2]])

    assert_allclose(ContourIntegrals(SQUARE).at(points).signed_distances, [1.0, -1.0, -5.0, 0.0, 0.2], atol=1e-12)


def test_near_a_long_straight_wall_the_repulsion_is_two_over_the_distance() -> None:
    at = ContourIntegrals(WIDE).at(np.array([[0.0, 0.1], [0.0, 0.5]]))

    assert_allclose(at.repulsion, [[0.0, 20.0], [0.0, 4.0]], atol=0.01)


def test_attraction_is_the_length_times_the_way_to_the_boundary_center() -> None:
    contour = load_shape("formation_2")
    integrals = ContourIntegrals(contour)
    points = np.array([[3.0, -20.0], [0.0, 0.0]])

    assert_allclose(integrals.at(points).attraction, integrals.length * (boundary_center(contour) - points))


def test_from_afar_transition_is_a_pull_of_the_length_of_the_contour() -> None:
    pull = ContourIntegrals(SQUARE).at(np.array([[1e6, 2.0]])).transition

    assert_allclose(pull, [[-16.0, 0.0]], atol=1e-4)


def test_outside_the_repulsion_points_away_and_transition_points_toward() -> None:
    at = ContourIntegrals(SQUARE).at(np.array([[2.0, -1.0]]))

    assert at.repulsion[0, 1] < 0.0 < at.transition[0, 1]


def test_on_the_contour_and_on_the_lines_of_its_edges_everything_is_finite() -> None:
    points = np.array([[2.0, 0.0], [0.0, 0.0], [4.0, 4.0], [7.0, 4.0], [4.0, -1e-9]])
    at = ContourIntegrals(SQUARE).at(points)

    for values in (at.attraction, at.repulsion, at.transition, at.signed_distances):
        assert np.isfinite(values).all()


def test_a_repeated_corner_changes_nothing() -> None:
    repeated = np.insert(SQUARE, 2, SQUARE[2], axis=0)
    points = np.array([[1.0, 3.0], [5.0, 3.5], [-2.0, 4.0]])

    once, twice = ContourIntegrals(SQUARE).at(points), ContourIntegrals(repeated).at(points)

    assert_allclose(twice.repulsion, once.repulsion)
    assert_allclose(twice.transition, once.transition)
    assert_array_equal(twice.inside, once.inside)
    assert_allclose(twice.signed_distances, once.signed_distances)
