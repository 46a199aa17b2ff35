import numpy as np
import pytest

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.contour import area_centroid
from swarm_msgs_py.partition.own_frame import OwnFrame


@pytest.mark.parametrize("name", ["formation_1", "formation_4", "iso_4_free"])
@pytest.mark.parametrize("turn", [0.7, 2.9, 4.4])
def test_a_shape_looks_the_same_in_its_own_frame_however_it_is_turned_and_moved(name: str, turn: float) -> None:
    straight = load_shape(name)
    moved = load_shape(name, rotation=turn, translation=(30.0, -20.0))

    np.testing.assert_allclose(OwnFrame(moved).enter(moved), OwnFrame(straight).enter(straight), atol=1e-6)


def test_what_leaves_is_what_entered() -> None:
    contour = load_shape("formation_2", translation=(7.0, 3.0))
    frame = OwnFrame(contour)

    np.testing.assert_allclose(frame.leave(frame.enter(contour)), contour, atol=1e-6)
    np.testing.assert_allclose(area_centroid(frame.enter(contour)), [0.0, 0.0], atol=1e-6)


def test_the_long_side_of_a_rectangle_lies_along_x() -> None:
    upright = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 4.0], [0.0, 4.0]])

    spread = np.ptp(OwnFrame(upright).enter(upright), axis=0)

    np.testing.assert_allclose(spread, [4.0, 1.0], atol=1e-12)


def test_a_square_has_no_long_side_and_stays_as_it_is() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])

    np.testing.assert_allclose(OwnFrame(square).enter(square), square - 1.0, atol=1e-12)


@pytest.mark.parametrize("name", ["iso_1_circle", "iso_2_rect", "iso_3_rect"])
@pytest.mark.parametrize("turn", [0.0, 0.5 * np.pi, 0.25 * np.pi, 1.1])
def test_last_bits_do_not_turn_an_even_shape_around(name: str, turn: float) -> None:
    contour = load_shape(name, rotation=turn)
    noise = np.random.default_rng(3)

    entered = {
        OwnFrame(contour * (1.0 + 2e-16 * noise.normal(size=contour.shape))).enter(contour[:1]).tobytes()
        for _ in range(20)
    }

    assert len(entered) == 1
