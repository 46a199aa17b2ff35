from __future__ import annotations

import numpy as np
import pytest
import shapely
from mesh_irregularity import mesh_irregularity

from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality, voronoi_mesh
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray


def hexagonal_lattice(rings: int) -> FloatArray:
    """Points of the unit triangular lattice within `rings` steps of the origin."""
    steps = range(-rings, rings + 1)
    return np.array([(i + 0.5 * j, 0.5 * np.sqrt(3.0) * j) for j in steps for i in steps if abs(i + j) <= rings])


def square_lattice(side: int) -> FloatArray:
    return np.array([(float(i), float(j)) for i in range(side) for j in range(side)])


def square(low: float, high: float) -> FloatArray:
    return np.array([[low, low], [high, low], [high, high], [low, high]])


def measured(centers: FloatArray, contour: FloatArray, radius: float = 0.1) -> MeshQuality:
    return mesh_quality(centers, np.full(len(centers), radius), contour)


def test_a_hexagonal_lattice_is_perfect_in_its_interior() -> None:
    quality = measured(hexagonal_lattice(4), np.array(shapely.Point(0, 0).buffer(4.2).exterior.coords)[:-1])

    assert quality.topological_interior == 0.0
    assert quality.geometrical == pytest.approx(0.0, abs=1e-9)
    assert quality.gap_variation == pytest.approx(0.0, abs=1e-9)


def test_whole_hexagonal_cells_have_the_ratio_of_a_hexagon() -> None:
    lattice = hexagonal_lattice(3)
    cells, _ = voronoi_mesh(hexagonal_lattice(5), shapely.Polygon(square(-9.0, 9.0)), 1e-6)
    contour = shapely.union_all([cell for cell in cells if shapely.distance(cell.centroid, shapely.Point(0, 0)) < 3.01])

    quality = measured(lattice, np.array(contour.normalize().exterior.coords)[:-1])

    # A hexagon's in-circle over its circum-circle is sqrt(3) / 2; every clipped cell here is a whole hexagon or less.
    assert quality.geometrical_cells == pytest.approx(1.0 - np.sqrt(3.0) / 2.0, abs=2e-3)
    assert quality.area_variation == pytest.approx(0.0, abs=1e-6)


def test_a_square_lattice_has_four_neighbors_and_right_triangles() -> None:
    quality = measured(square_lattice(7), square(-0.5, 6.5))

    assert quality.topological_interior == 2.0
    assert quality.area_variation == pytest.approx(0.0, abs=1e-9)
    # Right isosceles triangle with legs 1: r_in = 1 / (2 + sqrt 2), R_circ = sqrt(2) / 2.
    assert quality.geometrical == pytest.approx(0.5 - np.sqrt(2.0) / (2.0 + np.sqrt(2.0)), abs=1e-9)
    # Square: r_in = 1/2, R_enc = sqrt(2)/2.
    assert quality.geometrical_cells == pytest.approx(1.0 - 1.0 / np.sqrt(2.0), abs=2e-3)


def test_rim_robots_count_in_the_mean_over_all_only() -> None:
    quality = measured(square_lattice(3), square(-0.5, 2.5))

    # 4 corners with 2 neighbors, 4 edges with 3, the middle with 4.
    assert quality.topological == pytest.approx((4 * 4 + 4 * 3 + 2) / 9)
    assert quality.topological_interior == 2.0


def test_robots_in_two_bays_are_no_neighbors_though_their_cells_meet_outside() -> None:
    letter_u = np.array([[0, 0], [6, 0], [6, 6], [4, 6], [4, 2], [2, 2], [2, 6], [0, 6]], dtype=float)
    centers = np.array([[1.0, 5.0], [5.0, 5.0], [3.0, 1.0]])

    _, edges = voronoi_mesh(centers, shapely.Polygon(letter_u), 1e-6)

    assert edges.tolist() == [[0, 2], [1, 2]]


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_robots_leave_undefined_what_is_not_defined(count: int) -> None:
    quality = measured(square_lattice(3)[:count], square(-1.0, 4.0))

    assert quality.topological_interior is None
    assert quality.geometrical is None
    assert 0.0 < quality.covered_fraction < 1.0
    assert (quality.topological is None) == (count == 1)


def test_coverage_is_the_share_of_the_area_near_a_robot() -> None:
    side = 10.0
    quality = measured(np.array([[0.0, 0.0]]), square(-side / 2, side / 2))

    spacing = np.sqrt(2.0 * side**2 / np.sqrt(3.0))
    disc = shapely.Point(0, 0).buffer(0.65 * spacing, quad_segs=256).intersection(shapely.box(-5, -5, 5, 5))
    assert quality.covered_fraction == pytest.approx(disc.area / side**2, rel=1e-3)


@pytest.mark.parametrize("seed", range(5))
def test_random_formations_agree_with_the_slow_reference(seed: int) -> None:
    contour = np.array([[0, 0], [9, 0], [9, 4], [5, 4], [5, 9], [0, 9]], dtype=float)
    candidates = rng_for(seed, "mesh").uniform(0.0, 9.0, (60, 2))
    centers = candidates[shapely.contains_xy(shapely.Polygon(contour), candidates[:, 0], candidates[:, 1])]

    quality, reference = measured(centers, contour), mesh_irregularity(centers, contour)

    assert quality.topological == pytest.approx(reference.topological_all)
    assert quality.topological_interior == pytest.approx(reference.topological_interior)
    assert quality.geometrical == pytest.approx(reference.geometrical)
    assert quality.area_variation == pytest.approx(reference.area_variation)
