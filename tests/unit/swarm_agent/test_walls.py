"""Walls as landmarks: what a sensed point says, and when it had better say nothing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from swarm_agent.localization.motion_model import POSITION, belief_at
from swarm_agent.localization.range_fusion import SplitBelief, fuse_walls
from swarm_agent.localization.walls import NOTHING, Recognition, WallMap
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.world.obstacles import ObstacleField

LONG = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 1.0], [0.0, 1.0]])  # seen from below unless told otherwise
NOBODY = np.empty((0, 2)), np.empty(0)
EXACT_M = 1e-4


def look(
    truth: tuple[float, float],
    error: tuple[float, float],
    walls: tuple[FloatArray, ...] = (LONG,),
    sigma: float = 0.5,
    robots: tuple[FloatArray, FloatArray] = NOBODY,
) -> Recognition:
    """Return what a robot that is at `truth`, and believes to be `error` beside it, makes of its exact sensor."""
    _, spots = ObstacleField(walls).facing_points(np.array([truth]), 3.0)
    position = np.array(truth) + error
    return WallMap(walls).recognize(position, sigma**2 * np.eye(2), spots - truth, *robots)


def corrected(position: FloatArray, sigma: float, seen: Recognition) -> FloatArray:
    belief = SplitBelief(belief_at(position, sigma**2 * np.eye(2), 0.1, 1e-3), 0.0)
    after = fuse_walls(belief, seen.directions, seen.offsets, EXACT_M, 1e12)
    mean: FloatArray = after.gaussian.mean[POSITION]
    return mean


def test_a_face_corrects_exactly_the_error_along_its_normal() -> None:
    seen = look((5.0, -1.5), (0.4, 0.3))

    assert seen.directions.tolist() == [[0.0, -1.0]]
    assert_allclose(seen.offsets, [0.3])


def test_a_corner_corrects_both_axes() -> None:
    seen = look((11.0, -1.0), (0.4, 0.3))

    assert_allclose(corrected(np.array([11.4, -0.7]), 0.5, seen), [11.0, -1.0], atol=1e-6)


def test_a_face_and_an_inner_corner_between_two_faces_give_both_axes() -> None:
    room_corner = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [1.0, 1.0], [1.0, 6.0], [0.0, 6.0]])

    seen = look((2.5, 2.2), (0.3, -0.4), (room_corner,))

    assert len(seen.offsets) == 2  # one per face: the inner corner itself is no landmark
    assert_allclose(corrected(np.array([2.8, 1.8]), 0.5, seen), [2.5, 2.2], atol=1e-6)


def test_a_point_in_the_direction_of_an_inner_corner_is_taken_for_nothing() -> None:
    room_corner = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 1.0], [1.0, 1.0], [1.0, 6.0], [0.0, 6.0]])
    towards_it = np.array([[-1.0, -1.0]])

    seen = WallMap((room_corner,)).recognize(np.array([2.1, 2.1]), 0.25 * np.eye(2), towards_it, *NOBODY)

    assert not len(seen.offsets)


def test_a_face_does_not_end_before_the_robot() -> None:
    seen = look((9.6, -1.2), (0.9, 0.1))  # believes to be half a meter past the end, but sees the wall face to face

    assert_allclose(seen.directions, [[0.0, -1.0], [1.0, 0.0]])
    assert_allclose(seen.offsets, [0.1, -0.5])


def test_what_is_seen_within_the_length_of_a_face_says_nothing_along_it() -> None:
    assert look((9.0, -1.2), (0.9, 0.1)).directions.tolist() == [[0.0, -1.0]]


@pytest.mark.parametrize("robot", [(5.0, 0.1), (5.5, -0.3), (5.0, 2.0)])
def test_a_point_that_a_neighbor_may_have_made_is_no_wall(robot: tuple[float, float]) -> None:
    near, far = np.array([robot]), np.array([[5.0, 8.0]])

    assert len(look((5.0, -1.5), (0.0, 0.2), robots=(far, np.array([0.2]))).offsets) == 1
    assert look((5.0, -1.5), (0.0, 0.2), robots=(near, np.array([0.2]))) is NOTHING


def test_a_neighbor_that_does_not_know_where_it_is_may_be_anywhere() -> None:
    far = np.array([[5.0, 8.0]])

    assert look((5.0, -1.5), (0.0, 0.2), robots=(far, np.array([4.0]))) is NOTHING


def test_of_two_parallel_faces_that_both_may_be_meant_none_is() -> None:
    step = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 0.6], [10.0, 0.6], [10.0, 3.0], [0.0, 3.0]])

    ambiguous, clear = (look((4.8, -1.0), (0.05, 0.1), (step,), sigma) for sigma in (0.5, 0.1))

    assert not len(ambiguous.offsets)
    assert [0.0, -1.0] in clear.directions.tolist()


def test_a_wall_that_is_too_far_off_the_map_is_something_else() -> None:
    assert len(look((5.0, -1.5), (0.0, 0.5), sigma=0.2).offsets) == 1
    assert not len(look((5.0, -1.5), (0.0, 0.8), sigma=0.2).offsets)


def test_the_sense_of_rotation_and_the_first_corner_do_not_matter() -> None:
    for truth in ((5.0, -1.5), (11.0, -1.0), (9.6, -1.2)):
        one, *others = (look(truth, (0.3, 0.2), (corners,)) for corners in (LONG, LONG[::-1], np.roll(LONG, 2, axis=0)))
        assert len(one.offsets)
        for other in others:
            assert_allclose(other.directions, one.directions, atol=1e-15)
            assert_allclose(other.offsets, one.offsets)


def test_a_corner_that_is_told_twice_is_one() -> None:
    repeated = np.array([[0.0, 0.0], [0.0, 0.0], [10.0, 0.0], [10.0, 1.0], [10.0, 1.0], [0.0, 1.0], [0.0, 0.0]])

    for truth in ((5.0, -1.5), (11.0, -1.0), (-1.0, -1.0)):
        _, spots = ObstacleField((LONG,)).facing_points(np.array([truth]), 3.0)
        place = np.array(truth) + 0.2
        one, other = (WallMap((w,)).recognize(place, np.eye(2), spots - truth, *NOBODY) for w in (LONG, repeated))
        assert len(one.offsets)
        assert_allclose(other.offsets, one.offsets)


@pytest.mark.parametrize(
    "corners",
    [[[1.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[0.0, 0.0], [4.0, 0.0]], [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0]]],
    ids=["point", "twice a point", "line", "three on a line"],
)
def test_what_is_no_polygon_is_survived(corners: list[list[float]]) -> None:
    degenerate = np.array(corners)

    seen = WallMap((degenerate, LONG + 50.0)).recognize(
        np.array([55.0, 48.5]), 0.25 * np.eye(2), np.array([[0.0, 1.3], [0.3, 0.1]]), *NOBODY
    )

    assert np.isfinite(seen.offsets).all()
    assert_allclose(seen.directions[0], [0.0, -1.0], atol=1e-12)


def test_without_walls_or_points_there_is_nothing_to_recognize() -> None:
    point = np.array([[0.0, 1.0]])

    assert WallMap(()).recognize(np.zeros(2), np.eye(2), point, *NOBODY) is NOTHING
    assert WallMap((LONG,)).recognize(np.zeros(2), np.eye(2), np.empty((0, 2)), *NOBODY) is NOTHING


def test_a_point_on_the_robot_itself_is_survived() -> None:
    seen = WallMap((LONG,)).recognize(np.array([5.0, 0.0]), np.eye(2), np.zeros((1, 2)), *NOBODY)

    assert not len(seen.offsets)


def test_the_better_the_walls_fit_the_more_probable_is_the_place() -> None:
    likelihoods = [look((5.0, -1.5), (0.0, off), sigma=0.3).log_likelihood for off in (0.0, 0.3, 0.6, 5.0, 50.0)]

    assert likelihoods[0] > likelihoods[1] > likelihoods[2] > likelihoods[3] == likelihoods[4]


def convex_map(rng: np.random.Generator) -> tuple[FloatArray, ...]:
    """Return convex polygons apart from each other, one in each cell of a 3 x 3 grid of 8 m."""
    polygons = []
    for cell in range(9):
        angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, int(rng.integers(3, 7))))
        radius = rng.uniform(1.5, 3.5)
        center = 8.0 * np.array(divmod(cell, 3)) + rng.uniform(-0.4, 0.4, 2)
        polygons.append(center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return tuple(polygons)


@settings(max_examples=300, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6))
def test_with_a_small_error_recognition_moves_towards_the_truth_or_nowhere(seed: int) -> None:
    rng = rng_for(seed, "walls")
    walls = convex_map(rng)
    truth, sigma = rng.uniform(-2.0, 18.0, 2), 0.15
    field = ObstacleField(walls)
    assume(min(field.signed_distances(truth[None], k)[0] for k in range(field.count)) > 0.3)
    error = rng.uniform(-1.0, 1.0, 2) * sigma
    _, spots = field.facing_points(truth[None], 3.0)
    spots = spots[~field.is_blocked(np.tile(truth, (len(spots), 1)), spots - 1e-6 * (spots - truth))]

    seen = WallMap(walls).recognize(truth + error, sigma**2 * np.eye(2), spots - truth, *NOBODY)

    after = corrected(truth + error, sigma, seen) if len(seen.offsets) else truth + error
    assert np.hypot(*(after - truth)) <= np.hypot(*error) + 1e-6
