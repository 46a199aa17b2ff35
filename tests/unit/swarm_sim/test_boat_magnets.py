"""Docking mechanisms: who pulls whom, what latches, what the foils say."""

import numpy as np
import pytest

from swarm_msgs_py.assembly.faces import Face, Gender, Layout
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import CELL_M, MagnetConfig
from swarm_sim.boats.hulls import overlapping_hulls
from swarm_sim.boats.magnets import Magnets

RIGHT_ONLY: Layout = (0, 0, 0, 1)
LEFT_ONLY: Layout = (0, 0, 1, 0)
LEFT_SECOND: Layout = (0, 0, 2, 0)
GAPS = np.array([0.005, 0.02])


def pair(gap_m: float, turn: float = 0.0) -> np.ndarray:
    return np.array([[0.0, 0.0, 0.0], [CELL_M + gap_m, 0.0, turn]])


def magnets(other: Layout, gender: Gender, poses: np.ndarray) -> Magnets:
    found = Magnets(MagnetConfig(), [RIGHT_ONLY, other], gender)
    found.look_around(poses)
    return found


def test_sides_that_join_pull_and_the_more_the_nearer_they_are() -> None:
    near, far = (magnets(LEFT_ONLY, Gender.GENDERLESS, pair(gap)).wrenches(pair(gap)) for gap in GAPS)

    assert near[0, 0] > 10.0 * far[0, 0] > 0.0
    assert np.allclose(near[0, :2], -near[1, :2])
    assert not magnets(LEFT_ONLY, Gender.GENDERLESS, pair(0.035)).wrenches(pair(0.035)).any()


def test_sides_of_the_same_gender_push_and_never_latch() -> None:
    held = magnets(LEFT_ONLY, Gender.OPPOSITE, pair(0.002))

    assert held.wrenches(pair(0.002))[0, 0] < 0.0
    assert held.latch(pair(0.002)) == []


@pytest.mark.parametrize(
    ("gap", "turn", "latches"), [(0.009, 0.0, True), (0.011, 0.0, False), (0.0, 0.08, True), (0.0, 0.1, False)]
)
def test_sides_latch_when_they_are_close_and_face_each_other(gap: float, turn: float, latches: bool) -> None:
    poses = pair(gap, turn)

    assert bool(magnets(LEFT_SECOND, Gender.OPPOSITE, poses).latch(poses)) is latches


def test_a_turned_boat_docks_with_the_side_that_looks_there_now() -> None:
    poses = pair(0.0, np.pi)
    held = Magnets(MagnetConfig(), [RIGHT_ONLY, RIGHT_ONLY], Gender.GENDERLESS)
    held.look_around(poses)

    assert held.latch(poses) == [Latch(0, 1, Face.RIGHT, Face.RIGHT)]
    assert np.argwhere(held.contacts).tolist() == [[0, Face.RIGHT], [1, Face.RIGHT]]
    assert abs(held.latches[0].turn) == pytest.approx(np.pi)


def test_a_magnet_that_fails_lets_go_for_good() -> None:
    poses = pair(0.0)
    held = magnets(LEFT_ONLY, Gender.GENDERLESS, poses)
    latches = held.latch(poses)

    assert held.fail(1, Face.LEFT) == latches
    assert not held.contacts.any()
    held.look_around(poses)
    assert held.latch(poses) == []
    assert not held.wrenches(poses).any()


@pytest.mark.parametrize(
    ("other", "overlap"),
    [((0.244, 0.0, 0.0), True), ((0.246, 0.0, 0.0), False), ((0.2, 0.24, 0.0), True), ((0.27, 0.0, 0.7854), True)],
)
def test_hulls_overlap_where_their_squares_do(other: tuple[float, float, float], overlap: bool) -> None:
    found = overlapping_hulls(np.array([(0.0, 0.0, 0.0), other]), 0.245)

    assert found == ([(0, 1)] if overlap else [])
