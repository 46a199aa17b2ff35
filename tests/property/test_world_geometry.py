"""Laws of the world's geometry, against Shapely and brute force."""

from __future__ import annotations

import numpy as np
import shapely
from arena import ELL
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon

from swarm_sim.world.clearance import clearance
from swarm_sim.world.obstacles import ObstacleField, convex_pieces

SEEDS = st.integers(0, 2**32 - 1)


def random_star(rng: np.random.Generator, center: tuple[float, float]) -> np.ndarray:
    """Return a simple polygon, rarely convex."""
    corners = int(rng.integers(3, 9))
    angles = (np.arange(corners) + rng.uniform(0.0, 0.8, corners)) * 2.0 * np.pi / corners
    radii = rng.uniform(0.5, 3.0, corners)
    return np.column_stack([center[0] + radii * np.cos(angles), center[1] + radii * np.sin(angles)])


def random_field(rng: np.random.Generator) -> list[np.ndarray]:
    return [polygon for x in (-4.0, 4.0) if Polygon(polygon := random_star(rng, (x, 0.0))).is_valid] or [ELL]


@settings(max_examples=30)
@given(seed=SEEDS)
def test_signed_distance_agrees_with_shapely(seed: int) -> None:
    rng = np.random.default_rng(seed)
    polygon, points = random_field(rng)[0], rng.uniform(-8.0, 8.0, (20, 2))

    found = ObstacleField([polygon]).signed_distances(points, 0)

    shape, spots = Polygon(polygon), shapely.points(points)
    expected = shapely.distance(shape.exterior, spots) * np.where(shapely.contains(shape, spots), -1.0, 1.0)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@settings(max_examples=30)
@given(seed=SEEDS)
def test_line_of_sight_agrees_with_shapely(seed: int) -> None:
    rng = np.random.default_rng(seed)
    polygons = random_field(rng)
    shapes = [Polygon(polygon) for polygon in polygons]
    points = rng.uniform(-9.0, 9.0, (30, 2, 2))
    outside = [all(not s.intersects(Point(p)) for s in shapes for p in pair) for pair in points]
    points = points[outside]

    found = ObstacleField(polygons).is_blocked(points[:, 0], points[:, 1])

    assert found.tolist() == [any(s.intersects(LineString(pair)) for s in shapes) for pair in points]


@settings(max_examples=30)
@given(seed=SEEDS)
def test_the_nearest_point_of_an_obstacle_is_always_among_those_seen(seed: int) -> None:
    rng = np.random.default_rng(seed)
    polygon = random_field(rng)[0]
    shape = Polygon(polygon)
    points = np.array([p for p in rng.uniform(-8.0, 8.0, (20, 2)) if not shape.intersects(Point(p))]).reshape(-1, 2)

    observers, surface = ObstacleField([polygon]).facing_points(points, reach=30.0)

    for row, point in enumerate(points):
        seen = np.hypot(*(surface[observers == row] - point).T)
        np.testing.assert_allclose(seen.min(), shape.distance(Point(point)), atol=1e-9)
    assert shapely.distance(shape.exterior, shapely.points(surface)).max(initial=0.0) < 1e-9


@settings(max_examples=30)
@given(seed=SEEDS)
def test_convex_pieces_tile_the_polygon(seed: int) -> None:
    polygon = Polygon(random_field(np.random.default_rng(seed))[0])

    pieces = [Polygon(piece) for piece in convex_pieces(np.array(polygon.exterior.coords)[:-1])]

    assert all(piece.convex_hull.area - piece.area < 1e-6 for piece in pieces)
    assert shapely.union_all(pieces).symmetric_difference(polygon).area < 1e-6
    np.testing.assert_allclose(sum(piece.area for piece in pieces), polygon.area, rtol=1e-6)


@settings(max_examples=30)
@given(seed=SEEDS)
def test_clearance_equals_looking_at_every_pair_at_every_instant(seed: int) -> None:
    rng = np.random.default_rng(seed)
    polygons = random_field(rng)
    start = rng.uniform(-8.0, 8.0, (8, 2))
    samples = start + np.cumsum(rng.normal(scale=0.2, size=(6, 8, 2)), axis=0)
    radii = rng.uniform(0.1, 0.5, 8)

    found = clearance(start, samples, radii, ObstacleField(polygons))

    robots, walls = {}, {}
    for instant in (start, *samples):
        for i in range(8):
            for j in range(i + 1, 8):
                gap = np.hypot(*(instant[i] - instant[j])) - radii[i] - radii[j]
                robots[i, j] = min(robots.get((i, j), np.inf), gap)
            for k, polygon in enumerate(map(Polygon, polygons)):
                spot = Point(instant[i])
                signed = -polygon.exterior.distance(spot) if polygon.contains(spot) else polygon.distance(spot)
                walls[i, k] = min(walls.get((i, k), np.inf), signed - radii[i])
    np.testing.assert_allclose(found.min_gap, min(*robots.values(), *walls.values()), atol=1e-9)
    assert found.robot_overlaps == tuple(pair for pair, gap in sorted(robots.items()) if gap < 0.0)
    assert found.obstacle_overlaps == tuple(pair for pair, gap in sorted(walls.items()) if gap < 0.0)
