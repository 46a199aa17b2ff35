import re
from dataclasses import replace

import numpy as np
import pytest
from packed_shapes import FORMATIONS, centers_of, field_domain
from rosters import FIELD
from shapely import Point, Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.partition import Method, PartitionConfig, check_fits, partition
from swarm_msgs_py.partition.config import CircleSizes, FractalConfig, Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.fractals import RandomizedFractals
from swarm_msgs_py.partition.hurwitz import hurwitz_radii
from swarm_msgs_py.types import FloatArray

FRACTALS = PartitionConfig(method=Method.FRACTALS)
TOUCHING = Gaps(robot_m=0.01, contour_m=0.01)


def drawn(domain: Domain, **settings: object) -> FloatArray | None:
    return RandomizedFractals(FractalConfig(**settings)).place(domain)


def free_gaps(domain: Domain, centers: FloatArray) -> tuple[float, float]:
    """Least free distance between circles, and from circles to the contour."""
    apart = np.linalg.norm(centers[:, None] - centers, axis=2) - domain.radii[:, None] - domain.radii
    np.fill_diagonal(apart, np.inf)
    border = Polygon(domain.contour).exterior
    rim = min(border.distance(Point(p)) - r for p, r in zip(centers, domain.radii, strict=True))
    return float(apart.min()), float(rim)


def filled_to(share: float, shape: str) -> Domain:
    """A shape, scaled so that the field's circles have this share of its area."""
    domain = field_domain(shape)
    scale = np.sqrt(np.pi * (domain.radii**2).sum() / share / domain.area)
    return Domain(scale * domain.contour, (), domain.radii, TOUCHING)


@pytest.mark.parametrize("name", FORMATIONS)
def test_circles_keep_the_wanted_clearance_where_there_is_room(name: str) -> None:
    apart, rim = free_gaps(field_domain(name), centers_of(Method.FRACTALS, name))

    assert apart >= 0.7
    assert rim >= 0.35


def test_where_there_is_less_room_circles_keep_the_least_gaps() -> None:
    domain = field_domain("formation_1").scaled(0.55)

    centers = drawn(domain)

    assert drawn(replace(domain, gaps=Gaps(robot_m=0.7, contour_m=0.35))) is None
    assert centers is not None
    apart, rim = free_gaps(domain, centers)
    assert 0.3 <= apart < 0.7
    assert rim >= 0.15


def test_equal_seeds_draw_equal_goals_and_others_do_not() -> None:
    domain = field_domain("formation_3")

    first, again, other = (drawn(domain, seed=seed) for seed in (4, 4, 5))

    assert first is not None
    assert again is not None
    assert other is not None
    assert first.tobytes() == again.tobytes()
    assert np.abs(first - other).max() > 1.0


@pytest.mark.parametrize("name", ["iso_1_circle", "formation_4"])
def test_circles_with_half_the_area_always_find_room(name: str) -> None:
    domain = filled_to(0.53, name)

    assert all(drawn(domain, seed=seed, clearance_m=0.0) is not None for seed in range(8))


def test_circles_with_three_quarters_of_the_area_never_find_room() -> None:
    domain = filled_to(0.74, "iso_1_circle")

    assert all(drawn(domain, seed=seed, clearance_m=0.0) is None for seed in range(8))


def test_points_are_drawn_evenly_from_what_is_free() -> None:
    strip = np.array([[0.0, 0.0], [20.3, 0.0], [20.3, 2.4], [0.0, 2.4]])
    domain = Domain(strip, (), np.array([1.0]), Gaps(robot_m=0.01, contour_m=0.14))

    draws = [drawn(domain, seed=seed, clearance_m=0.0) for seed in range(200)]

    along = np.sort([centers[0, 0] for centers in draws if centers is not None])

    # Kolmogorov and Smirnov: even numbers stay within 1.63 / sqrt(200) of the diagonal in 99 of 100 cases.
    even = (np.arange(200) + 0.5) / 200
    assert np.abs((along - 1.153) / 17.994 - even).max() < 1.63 / np.sqrt(200)


def test_circles_of_the_hurwitz_rule_do_not_overlap_and_the_largest_hold_large_robots() -> None:
    domain = field_domain("formation_3")

    centers = drawn(domain, sizes=CircleSizes.HURWITZ)

    assert centers is not None
    order = np.argsort(-domain.radii, kind="stable")
    sizes = hurwitz_radii(domain.area, len(order), 1.2, 2.0)
    ranked = centers[order]
    apart = np.linalg.norm(ranked[:, None] - ranked, axis=2) - sizes[:, None] - sizes
    assert apart[np.triu_indices(len(order), 1)].min() >= -1e-9
    assert free_gaps(domain, centers)[0] >= 0.3


def test_a_shape_that_is_too_small_names_the_circle_the_free_area_and_a_scale_that_is_enough() -> None:
    with pytest.raises(ShapeError) as caught:
        partition(load_shape("formation_2", scale=0.3), FIELD, config=FRACTALS)

    words = re.search(
        r"needs .* scale it by at least ([\d.]+) \(circle (\d+) of 50, for type ([123]) of radius ([\d.]+) m,"
        r" found no room; ([\d.]+) m2 are free\)",
        str(caught.value),
    )
    assert words is not None
    scale, circle, kind, radius, free = (float(word) for word in words.groups())
    radii = np.sort(field_domain("formation_2").radii)[::-1]
    assert radius == radii[int(circle) - 1] == {1.0: 0.15, 2.0: 0.3, 3.0: 0.5}[kind]
    assert free == pytest.approx(310.0 * 0.09 - np.pi * (radii[: int(circle) - 1] ** 2).sum(), rel=0.01)
    check_fits(load_shape("formation_2", scale=0.3 * scale), FIELD, config=FRACTALS)


def test_circles_keep_clear_of_obstacles_in_the_shape() -> None:
    contour = load_shape("formation_3")
    body = contour.mean(axis=0) + np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])

    goals = partition(contour, FIELD, config=FRACTALS, keep_outs=(body,))

    radii = FIELD.radii_of(goals.types)
    gaps = [Polygon(body).distance(Point(p)) - r for p, r in zip(goals.positions, radii, strict=True)]
    assert min(gaps) >= FRACTALS.gaps.obstacle_m


def test_where_the_hurwitz_rule_finds_no_room_its_settings_are_named_and_no_scale() -> None:
    contour = load_shape("formation_2")
    hurwitz = replace(FRACTALS, fractals=FractalConfig(sizes=CircleSizes.HURWITZ, exponent=1.9, shift=1.0))

    with pytest.raises(
        ShapeError, match=r"Hurwitz rule \(exponent 1.9, shift 1\) .* scaling it does not help"
    ) as caught:
        partition(contour, FIELD, config=hurwitz)

    for remedy in ("lower partition.fractals.exponent", "raise partition.fractals.shift", "sizes to coverage"):
        assert remedy in str(caught.value)
    partition(contour, FIELD, config=replace(hurwitz, fractals=replace(hurwitz.fractals, exponent=1.05, shift=50.0)))
