"""Which points of two contours belong together."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.geometry.correspondence import CORNERS_MAX, VERTICES_MAX, matched, resampled
from swarm_msgs_py.types import FloatArray

L_SHAPE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [2.0, 2.0], [2.0, 5.0], [0.0, 5.0]])


def corners_among(points: FloatArray, corners: FloatArray) -> bool:
    nearest = np.linalg.norm(points[:, None] - corners, axis=2).min(axis=0)
    return bool(nearest.max() < 1e-9)


@pytest.mark.parametrize("shift", [0, 2, 5])
def test_a_contour_that_is_moved_and_scaled_belongs_to_itself_point_by_point(shift: int) -> None:
    target = np.roll(1.5 * L_SHAPE + [30.0, -7.0], -shift, axis=0)

    first, last = matched(L_SHAPE, target)

    assert_allclose(last, 1.5 * first + [30.0, -7.0], atol=1e-9)
    assert corners_among(first, L_SHAPE)


def test_all_corners_of_both_have_partners() -> None:
    start, target = load_shape("iso_1_circle"), load_shape("iso_2_rect")

    first, last = matched(start, target)

    assert first.shape == last.shape
    assert corners_among(first, start)
    assert corners_among(last, target)
    assert signed_area(first) == pytest.approx(signed_area(start))
    assert signed_area(last) == pytest.approx(signed_area(target))


def test_what_both_have_in_common_is_matched_exactly_around_a_dent() -> None:
    dented = np.insert(L_SHAPE, 1, [[2.0, 0.0], [3.0, 0.7], [4.0, 0.0]], axis=0)

    first, last = matched(L_SHAPE, dented)

    apart = np.linalg.norm(first - last, axis=1)
    elsewhere = (first[:, 0] < 2.0 - 1e-9) | (first[:, 0] > 4.0 + 1e-9) | (first[:, 1] > 1e-9)
    along = np.abs(first - last)[elsewhere]
    assert along[:, 1].max() < 1e-6  # on the dented side points may be matched a little along it, nowhere else
    assert apart[first[:, 1] > 1e-9].max() < 1e-6
    assert apart.max() == pytest.approx(0.7, abs=0.1)


def test_the_sides_of_a_cut_come_out_of_a_short_piece_at_its_end() -> None:
    rectangle = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 5.0], [0.0, 5.0]])
    notched = np.insert(rectangle, 1, [[5.9, 0.0], [5.9, 4.5], [6.1, 4.5], [6.1, 0.0]], axis=0)

    first, last = matched(rectangle, notched)

    deep = first[(last[:, 1] > 1.0) & (last[:, 1] < 4.0) & (np.abs(last[:, 0] - 6.0) < 0.2)]
    assert len(deep) > 2
    assert np.ptp(deep, axis=0).max() < 2.5  # of 6 m that are deep
    assert_allclose(deep.mean(axis=0), [6.0, 0.0], atol=1.0)


def test_contours_of_thousands_of_points_are_resampled_first() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])

    first, last = matched(5.0 * circle, L_SHAPE)

    assert len(first) == len(last) < 3 * CORNERS_MAX


def around(corners: FloatArray, a: float, b: float) -> FloatArray:
    return np.column_stack([a * np.cos(corners), b * np.sin(corners)])


CROWD = np.concatenate([np.linspace(-0.15, 0.15, 470), np.linspace(0.2, 2.0 * np.pi - 0.2, 30)])
SPREAD = np.linspace(0.0, 2.0 * np.pi, 500, endpoint=False)


@pytest.mark.parametrize("corners", [CROWD, SPREAD], ids=["crowd", "spread"])
def test_hundreds_of_corners_take_a_few_megabytes_and_all_find_their_partners(corners: FloatArray) -> None:
    start, target = around(corners, 100.0, 100.0), around(corners, 140.0, 80.0)

    tracemalloc.start()
    try:
        first, last = matched(start, target)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()

    assert peak < 50e6
    assert len(first) <= 4 * VERTICES_MAX + 2 * len(corners)
    assert corners_among(first, start)
    assert corners_among(last, target)


def test_one_long_edge_among_short_ones_is_divided_no_more_than_all_may_be() -> None:
    comb = np.array([[0.1 * k, 0.1 * (k % 2)] for k in range(100)] + [[9.9, 9000.0], [0.0, 9000.0]])

    first, last = matched(comb, 2.0 * comb)

    assert len(first) <= 2 * VERTICES_MAX
    assert_allclose(last, 2.0 * first, atol=1e-6)


@pytest.mark.parametrize("shift", [[30.0, -7.0], [0.37, 1000.11]])
def test_what_is_shifted_keeps_the_same_corners_of_many(shift: list[float]) -> None:
    start = around(SPREAD, 40.0, 25.0).round(2)

    first, last = matched(start, start + shift)

    assert_allclose(last, first + shift, atol=1e-9)


def test_resampling_puts_points_at_equal_distances_from_the_first_on() -> None:
    points = resampled(L_SHAPE, 11)  # 22 m around

    assert_allclose(points[:5], [[0.0, 0.0], [2.0, 0.0], [4.0, 0.0], [6.0, 0.0], [6.0, 2.0]], atol=1e-12)
