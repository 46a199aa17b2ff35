import numpy as np
import pytest
import shapely
from packed_shapes import field_domain, random_points

from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.power_diagram import PowerDiagram
from swarm_msgs_py.types import FloatArray


def clipped_cells(sites: FloatArray, weights: FloatArray, shape: shapely.Polygon) -> list[shapely.Polygon]:
    """Power cells as polygons, cut out of the shape half-plane by half-plane."""
    cells = []
    for site, weight in zip(sites, weights, strict=True):
        cell: shapely.Polygon = shape
        for other, heavier in zip(sites, weights, strict=True):
            normal = 2.0 * (other - site)
            if not normal.any():
                continue
            unit = normal / np.linalg.norm(normal)
            along = np.array([-unit[1], unit[0]])
            foot = unit * (other @ other - heavier - site @ site + weight) / np.linalg.norm(normal)
            far = 1000.0
            corners = [foot + far * along, foot - far * along, foot - far * (along + unit), foot + far * (along - unit)]
            cell = cell.intersection(shapely.Polygon(corners))
        cells.append(cell)
    return cells


def holed(name: str) -> shapely.Polygon:
    contour = field_domain(name).contour
    contour = contour - contour.mean(axis=0)
    shape = shapely.Polygon(contour)
    hole = shape.representative_point().buffer(1.0)
    return shape.difference(hole)


@pytest.mark.parametrize("name", ["formation_4", "iso_4_free"])
def test_moments_of_cells_in_a_bent_shape_with_a_hole_are_those_of_the_clipped_polygons(name: str) -> None:
    shape = holed(name)
    sites = random_points(name, 3)[:20] - field_domain(name).contour.mean(axis=0)
    weights = np.random.default_rng(4).uniform(0.0, 2.0, len(sites))
    region = Region(shape)

    moments = region.moments(PowerDiagram(sites, weights, region.far))

    for row, cell in enumerate(clipped_cells(sites, weights, shape)):
        center = np.array(cell.centroid.coords[0]) if cell.area else np.zeros(2)
        assert moments.areas[row] == pytest.approx(cell.area, abs=1e-9)
        np.testing.assert_allclose(moments.firsts[row], cell.area * center, atol=1e-8)
        assert moments.touching[row] == (cell.area > 0.0 and cell.distance(shape.boundary) < 1e-9)


def test_the_energy_of_one_cell_is_the_second_moment_about_its_site() -> None:
    region = Region(shapely.box(-1.0, -2.0, 1.0, 2.0))
    site = np.array([[0.5, 0.0]])

    moments = region.moments(PowerDiagram(site, np.zeros(1), region.far))

    # Of a rectangle a x b about its center a b (a^2 + b^2) / 12, and A d^2 for a site at the distance d.
    assert moments.energies[0] == pytest.approx(8.0 * 20.0 / 12.0 + 8.0 * 0.25)
    assert moments.touching.all()


def test_a_denser_core_counts_by_its_density() -> None:
    whole, core = shapely.box(-2.0, -2.0, 2.0, 2.0), shapely.box(0.0, 0.0, 1.0, 1.0)
    region = Region(whole, core, 3.0)

    moments = region.moments(PowerDiagram(np.array([[-1.0, 0.0], [1.0, 0.0]]), np.zeros(2), region.far))

    np.testing.assert_allclose(moments.areas, [8.0, 8.0 + 3.0])
    np.testing.assert_allclose(moments.firsts, [[-8.0, 0.0], [8.0 + 1.5, 1.5]], atol=1e-12)


def test_a_core_that_is_empty_changes_nothing() -> None:
    whole = shapely.box(-2.0, -2.0, 2.0, 2.0)
    sites = PowerDiagram(np.array([[-1.0, 0.3], [1.0, 0.0], [0.0, 1.0]]), np.zeros(3), 100.0)

    np.testing.assert_array_equal(
        Region(whole).moments(sites).areas, Region(whole, shapely.Polygon(), 1.0).moments(sites).areas
    )


def test_edges_count_as_far_as_they_are_inside() -> None:
    notched = shapely.box(-2.0, -2.0, 2.0, 2.0).difference(shapely.box(-0.5, -1.0, 0.5, 0.5))
    region = Region(notched)
    diagram = PowerDiagram(np.array([[-1.0, 0.0], [1.0, 0.0]]), np.zeros(2), region.far)

    between = (diagram.pairs < 2).all(axis=1)

    np.testing.assert_allclose(region.lengths_inside(diagram)[between], [2.5])


def test_a_site_that_others_outweigh_has_no_cell() -> None:
    region = Region(shapely.box(-2.0, -2.0, 2.0, 2.0))
    sites = np.array([[-1.0, 0.0], [0.0, 0.0], [1.0, 0.0]])

    moments = region.moments(PowerDiagram(sites, np.array([5.0, 0.0, 5.0]), region.far))

    np.testing.assert_allclose(moments.areas, [8.0, 0.0, 8.0], atol=1e-12)


def test_points_in_holes_are_outside() -> None:
    shape = holed("formation_1")
    points = np.random.default_rng(5).uniform(-12.0, 12.0, (500, 2))

    np.testing.assert_array_equal(Region(shape).contains(points), shapely.contains_xy(shape, points))
