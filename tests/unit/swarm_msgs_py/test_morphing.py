"""Contours on their way from one shape to another."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from shapely import Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry import morphing
from swarm_msgs_py.geometry.bridges import split
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.geometry.morphing import Morph, morph_between
from swarm_msgs_py.types import FloatArray

L_SHAPE = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 2.0], [2.0, 2.0], [2.0, 5.0], [0.0, 5.0]])
AWAY = np.array([5.0, 0.0])
SHARES = np.linspace(0.0, 1.0, 41)


def turned(contour: FloatArray, angle: float) -> FloatArray:
    center = area_centroid(contour)
    cosine, sine = np.cos(angle), np.sin(angle)
    return center + (contour - center) @ np.array([[cosine, sine], [-sine, cosine]])


def same_outline(one: FloatArray, other: FloatArray) -> bool:
    return bool(Polygon(one).symmetric_difference(Polygon(other)).area < 1e-6)


def test_it_begins_and_ends_with_the_very_contours() -> None:
    start, target = load_shape("formation_3"), load_shape("formation_1")
    morph = Morph(start, target)

    assert_array_equal(morph.at(0.0), start)
    assert_array_equal(morph.at(1.0), target)


@pytest.mark.parametrize("share", [0.25, 0.5, 0.8])
def test_a_translation_with_growth_keeps_the_shape(share: float) -> None:
    blend = share * share * (3.0 - 2.0 * share)  # spec 13: smooth step
    scale = np.sqrt(1.0 - blend + blend * 4.0)  # the area, not the length, grows evenly
    center = area_centroid(L_SHAPE)

    contour = Morph(L_SHAPE, center + [10.0, -4.0] + 2.0 * (L_SHAPE - center)).at(share)

    assert same_outline(contour, center + blend * np.array([10.0, -4.0]) + scale * (L_SHAPE - center))


@pytest.mark.parametrize("angle", [np.pi / 2.0, np.pi, -np.pi, 2.0 * np.pi, 4.0 * np.pi])
def test_a_turn_that_is_told_keeps_the_shape_all_the_way(angle: float) -> None:
    morph = Morph(L_SHAPE, turned(L_SHAPE, angle), angle)

    assert same_outline(morph.at(0.5), turned(L_SHAPE, 0.5 * angle))


def test_a_turn_by_half_that_is_not_told_is_another_motion() -> None:
    bar = np.array([[0.0, 0.0], [8.0, 0.0], [8.0, 1.0], [0.0, 1.0]])
    half = 0.5

    assert not same_outline(Morph(bar, turned(bar, np.pi)).at(half), turned(bar, np.pi / 2.0))


@pytest.mark.parametrize(
    ("start", "target"),
    [("formation_3", "formation_1"), ("iso_1_circle", "iso_2_rect"), ("formation_1", "formation_2"),
     ("formation_2", "formation_4"), ("iso_3_rect", "iso_4_free")],
)  # fmt: skip
def test_on_the_way_it_is_a_simple_contour_whose_area_changes_evenly(start: str, target: str) -> None:
    morph = Morph(load_shape(start), load_shape(target))
    first, last = signed_area(load_shape(start)), signed_area(load_shape(target))

    for share in SHARES:
        contour = morph.at(share)
        blend = share * share * (3.0 - 2.0 * share)
        assert Polygon(contour).is_valid
        assert signed_area(contour) == pytest.approx(first + blend * (last - first), rel=1e-3)


def test_it_moves_continuously() -> None:
    morph = Morph(load_shape("formation_1"), split(load_shape("formation_1"), 0.3, 6.0))
    shapes = [Polygon(morph.at(share)) for share in np.linspace(0.0, 1.0, 201)]

    jumps = [one.symmetric_difference(other).area for one, other in pairwise(shapes)]

    assert max(jumps) < 0.02 * shapes[0].area


@pytest.mark.parametrize(
    ("name", "direction"), [("formation_3", 0.0), ("formation_3", 0.7), ("formation_1", 1.57), ("formation_2", 1.65)]
)
def test_a_shape_parts_in_two_and_comes_together_again(name: str, direction: float) -> None:
    whole = load_shape(name)
    halves = split(whole, direction, 6.0)

    for morph in (Morph(whole, halves), Morph(halves, whole)):
        assert all(Polygon(morph.at(share)).is_valid for share in SHARES)


def test_a_contour_that_cannot_but_cross_itself_is_refused_with_a_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    spiral = np.array([[0, 0], [9, 0], [9, 9], [1, 9], [1, 3], [6, 3], [6, 6], [4, 6], [4, 5], [5, 5], [5, 4], [2, 4],
                       [2, 8], [8, 8], [8, 1], [0, 1]], dtype=float)  # fmt: skip
    mirrored = spiral[::-1] * [-1.0, 1.0]
    monkeypatch.setattr(morphing, "matched", lambda one, other, *_: morphing._matched_evenly(one, other))

    with pytest.raises(ShapeError, match=r"would cross itself .* go by way of a shape in between"):
        Morph(spiral, mirrored)


def test_points_take_part_in_a_turn_and_a_translation() -> None:
    morph = Morph(L_SHAPE, turned(L_SHAPE, np.pi / 2.0) + AWAY, np.pi / 2.0)
    inner = np.array([[1.0, 1.0], [5.0, 1.0]])

    halfway = morph.carried(inner, 0.0, 0.5)

    assert_allclose(morph.carried(halfway, 0.5, 1.0), morph.carried(inner, 0.0, 1.0), atol=1e-9)
    assert_allclose(np.linalg.norm(halfway[0] - halfway[1]), 4.0, atol=1e-9)
    around = np.concatenate([inner, area_centroid(L_SHAPE)[None]])
    assert_allclose(morph.carried(around, 0.0, 1.0)[2], area_centroid(L_SHAPE) + AWAY, atol=1e-9)


@pytest.mark.parametrize("rounds", [1, 2, -1])
def test_points_go_around_with_a_contour_that_ends_where_it_began(rounds: int) -> None:
    morph = Morph(L_SHAPE, L_SHAPE, rounds * 2.0 * np.pi)
    inner = np.array([[1.0, 1.0], [5.0, 1.0]])
    share = 0.2

    turn = rounds * 2.0 * np.pi * share * share * (3.0 - 2.0 * share)
    cosine, sine = np.cos(turn), np.sin(turn)
    center = area_centroid(L_SHAPE)
    expected = center + (inner - center) @ np.array([[cosine, sine], [-sine, cosine]])
    assert_allclose(morph.carried(inner, 0.0, share), expected, atol=1e-9)
    assert_allclose(morph.carried(inner, 0.0, 1.0), inner, atol=1e-9)


def test_points_rest_where_most_of_the_contour_does() -> None:
    dented = np.insert(L_SHAPE, 1, [[2.0, 0.0], [3.0, 0.7], [4.0, 0.0]], axis=0)
    morph = Morph(L_SHAPE, dented)
    points = np.array([[1.0, 4.0], [3.0, 1.0]])

    assert_array_equal(morph.carried(points, 0.2, 0.9), points)
    assert_allclose(morph.distances_to_change(points), [np.hypot(1.0, 4.0), 0.3], atol=0.3)


def test_a_common_motion_changes_nothing_anywhere() -> None:
    morph = Morph(L_SHAPE, 2.0 * L_SHAPE + [1.0, 1.0])

    assert_array_equal(morph.distances_to_change(L_SHAPE), np.inf)


def test_what_is_no_morph_is_found_out_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tried: list[object] = []

    def impossible(*contours_and_turn: object) -> None:
        tried.append(contours_and_turn[-1])
        raise ShapeError("none")

    monkeypatch.setattr(morphing, "Morph", impossible)
    for _ in range(3):
        with pytest.raises(ShapeError, match="none"):
            morph_between(L_SHAPE, 1.25 * L_SHAPE, 0.123)

    assert tried == [0.123]


@pytest.mark.parametrize("target", [L_SHAPE[::-1], L_SHAPE[:2], L_SHAPE[:0], L_SHAPE[[0, 2, 1, 3]]])
def test_a_morph_to_what_is_no_contour_is_refused(target: FloatArray) -> None:
    with pytest.raises(ShapeError, match="cross themselves, run clockwise or enclose nothing"):
        morph_between(L_SHAPE, target)


def test_a_morph_is_made_once() -> None:
    start, target = load_shape("formation_3"), load_shape("formation_1")

    assert morph_between(start, target) is morph_between(start.copy(), target.copy())
    assert morph_between(start, target) is not morph_between(start, target, 0.1)
