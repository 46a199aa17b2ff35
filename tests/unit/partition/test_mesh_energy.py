import numpy as np
import pytest
import shapely
from packed_shapes import field_domain, random_points

from swarm_msgs_py.geometry.mesh_quality import mesh_quality
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.lattice_starts import lattice_starts
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame

NAME = "formation_1"
DOMAIN = field_domain(NAME)
FRAME = OwnFrame(DOMAIN.contour)
SHAPE = shapely.Polygon(FRAME.enter(DOMAIN.contour))
SITES = FRAME.enter(random_points(NAME, 7))


@pytest.mark.parametrize("gain", [0.0, 0.3])
def test_the_gradient_is_the_slope_of_the_energy(gain: float) -> None:
    region = Region(SHAPE, SHAPE.buffer(-1.5), 0.6)
    energy = MeshEnergy(region, SHAPE.area, 0.5 * DOMAIN.radii, gain)
    rng = np.random.default_rng(2)
    # Flat triangles have steep and hardly predictable slopes; a lattice shaken a little has none.
    (lattice,) = lattice_starts(SHAPE, 0.95 * DOMAIN.spacing, len(DOMAIN.radii), 1)
    sites = lattice + rng.normal(0.0, 0.1, lattice.shape)
    _, gradient = energy(sites)

    for _ in range(5):
        way = rng.normal(size=sites.shape)
        slope = (energy(sites + 1e-5 * way)[0] - energy(sites - 1e-5 * way)[0]) / 2e-5
        assert slope == pytest.approx(float((gradient * way).sum()), rel=1e-4, abs=1e-4)


def test_a_step_along_the_gradient_of_equal_cells_is_the_way_to_their_centers() -> None:
    square = shapely.box(-2.0, -1.0, 2.0, 1.0)
    energy = MeshEnergy(Region(square), square.area, np.zeros(2), 0.0)
    sites = np.array([[-0.5, 0.25], [0.5, 0.25]])

    np.testing.assert_allclose(sites - energy(sites)[1], [[-1.0, 0.0], [1.0, 0.0]], atol=1e-12)


def test_a_lattice_is_more_regular_than_random_points_and_fewer_defects_than_more() -> None:
    energy = MeshEnergy(Region(SHAPE), SHAPE.area, np.zeros(len(SITES)), 0.0)
    (lattice,) = lattice_starts(SHAPE, DOMAIN.spacing, len(SITES), 1)
    shaken = lattice + np.random.default_rng(3).normal(0.0, 0.4, lattice.shape)

    irregular = [energy.irregularity(sites) for sites in (lattice, shaken, SITES)]

    assert irregular == sorted(irregular)
    assert irregular[2] > 2.0 * irregular[0]


def test_its_parts_are_those_of_the_metrics() -> None:
    energy = MeshEnergy(Region(SHAPE), SHAPE.area, np.zeros(len(SITES)), 0.0)

    quality = mesh_quality(SITES, DOMAIN.radii, FRAME.enter(DOMAIN.contour))

    parts = (quality.topological, quality.topological_interior, quality.geometrical, quality.area_variation)
    weighted = sum(w * p for w, p in zip((1.5, 1.0, 20.0, 3.0), parts, strict=True) if p is not None)
    assert energy.irregularity(SITES, 1.5) == pytest.approx(weighted, rel=1e-6)


def test_the_largest_hole_is_where_a_site_was_taken_away() -> None:
    square = shapely.box(-4.0, -4.0, 4.0, 4.0)
    grid = np.array([[x, y] for x in (-3.0, -1.0, 1.0, 3.0) for y in (-3.1, -1.0, 1.0, 3.0)])
    sites = grid[~(grid == [1.0, 1.0]).all(axis=1)]
    energy = MeshEnergy(Region(square), square.area, np.zeros(len(sites)), 0.0)

    hole = energy.largest_hole(sites, 0)

    assert hole is not None
    np.testing.assert_allclose(hole, [1.0, 1.0], atol=1e-6)


def test_two_sites_have_no_hole_between_them() -> None:
    square = shapely.box(-4.0, -4.0, 4.0, 4.0)
    energy = MeshEnergy(Region(square), square.area, np.zeros(2), 0.0)

    assert energy.largest_hole(np.array([[-1.0, 0.0], [1.0, 0.0]]), 0) is None
