import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.contour_integrals import ShapeForce
from swarm_msgs_py.types import FloatArray


def summed(contour: FloatArray, point: FloatArray, spacing: float) -> FloatArray:
    """The thesis' sum over points of the contour, with ds (spec E2)."""
    total = np.zeros(2)
    for start, end in zip(contour, np.roll(contour, -1, axis=0), strict=True):
        count = int(np.ceil(np.linalg.norm(end - start) / spacing))
        along = (np.arange(count) + 0.5) / count
        offsets = point - (start + along[:, None] * (end - start))
        ds = np.linalg.norm(end - start) / count
        total += ds * (offsets / np.linalg.norm(offsets, axis=1)[:, None] ** 3).sum(axis=0)
    return total


@pytest.mark.parametrize("name", ["formation_1", "hw_4_arrow"])
def test_the_closed_form_is_the_limit_of_the_sum(name: str) -> None:
    contour = load_shape(name)
    center = contour.mean(axis=0)
    points = center + np.array([0.0, 0.3, 0.6, 0.8])[:, None] * (contour[1] - center)
    spacing = np.linalg.norm(np.ptp(contour, axis=0)) / 20_000

    expected = np.array([summed(contour, point, spacing) for point in points])

    assert_allclose(ShapeForce(contour).at(points), expected, rtol=1e-4, atol=1e-6)


def test_near_a_long_straight_wall_the_force_is_two_over_the_distance() -> None:
    wide = np.array([[-1000.0, 0.0], [1000.0, 0.0], [1000.0, 1000.0], [-1000.0, 1000.0]])

    force = ShapeForce(wide).at(np.array([[0.0, 0.1], [0.0, 0.5]]))

    assert_allclose(force, [[0.0, 20.0], [0.0, 4.0]], atol=0.01)


def test_on_the_contour_the_force_is_finite() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])

    assert np.isfinite(ShapeForce(square).at(np.array([[2.0, 0.0], [0.0, 0.0], [4.0, 4.0]]))).all()
