"""How evenly a formation fills its shape: mesh irregularities and coverage (spec sections 14.1, 14.2, 14.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import Delaunay, QhullError, Voronoi
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.types import FloatArray, IntArray

HEXAGON = 6  # neighbors of a node in a perfect plane mesh (D of thesis eq. (3.104))
EQUILATERAL = 0.5  # inscribed over circumscribed radius of an equilateral triangle (A of thesis eq. (3.106))
FAR = 10.0  # auxiliary sites stand this many extents away: farther from any point of the shape than every robot
EDGE_MIN = 1e-6  # cells that share less than this fraction of the mean spacing share a corner, not an edge
REACH = 0.65  # spec 14.6: a point is covered when a robot is within 0.65 hexagonal spacings
CIRCLE_TOLERANCE = 1e-3  # of the largest inscribed circle, as a fraction of the spacing


@dataclass(frozen=True, slots=True)
class MeshQuality:
    """Regularity of a formation; None where it is not defined (too few robots, no interior robot).

    Attributes
    ----------
    topological_interior : float or None
        Mean of abs(neighbors - 6) over robots whose clipped cell does not touch the contour; 0 is perfect.
    topological : float or None
        The same over all robots.
    geometrical : float or None
        Mean of 0.5 - r_in / R_circ over the Delaunay triangles whose circumcenter is inside; 0 is perfect.
    geometrical_cells : float or None
        Mean of 1 - r_in / R_enc over the clipped cells.
    area_variation : float or None
        Coefficient of variation of the clipped cells' areas.
    gap_variation : float or None
        Coefficient of variation of the free gaps between neighbors.
    covered_fraction : float
        Share of the shape's area within 0.65 hexagonal spacings of a robot.
    """

    topological_interior: float | None
    topological: float | None
    geometrical: float | None
    geometrical_cells: float | None
    area_variation: float | None
    gap_variation: float | None
    covered_fraction: float


def mesh_quality(centers: FloatArray, radii: FloatArray, contour: FloatArray) -> MeshQuality:
    """Measure a formation.

    Parameters
    ----------
    centers : (n, 2) array
        Robots, n >= 1, no two at one point [m].
    radii : (n,) array
        Their coverage radii [m].
    contour : (k, 2) array
        The shape that they fill [m].
    """
    return mesh_quality_in(shapely.Polygon(contour), centers, radii)


def mesh_quality_in(shape: BaseGeometry, centers: FloatArray, radii: FloatArray) -> MeshQuality:
    """Measure a formation in a shape that may have holes and several parts; the rest as `mesh_quality`."""
    spacing = float(np.sqrt(2.0 * shape.area / (np.sqrt(3.0) * len(centers))))  # spec 9.2
    cells, edges = voronoi_mesh(centers, shape, EDGE_MIN * spacing)
    clipped = shapely.intersection(cells, shape)
    clipped = clipped[shapely.area(clipped) > 0.0]
    mixed = shapely.get_type_id(clipped) == shapely.GeometryType.GEOMETRYCOLLECTION  # with points or lines of contact
    clipped[mixed] = shapely.buffer(clipped[mixed], 0.0)
    deviation = np.abs(np.bincount(edges.ravel(), minlength=len(centers)) - HEXAGON)
    interior = shapely.contains_properly(shape, cells)
    gaps = np.linalg.norm(centers[edges[:, 0]] - centers[edges[:, 1]], axis=1) - radii[edges].sum(axis=1)
    discs = shapely.union_all(shapely.buffer(shapely.points(centers), REACH * spacing, quad_segs=32))
    return MeshQuality(
        topological_interior=_mean(deviation[interior]),
        topological=_mean(deviation) if len(centers) > 1 else None,
        geometrical=_mean(_triangle_irregularity(centers, shape)),
        geometrical_cells=_mean(_cell_irregularity(clipped, CIRCLE_TOLERANCE * spacing)),
        area_variation=_variation(shapely.area(clipped)),
        gap_variation=_variation(gaps),
        covered_fraction=float(discs.intersection(shape).area / shape.area),
    )


def voronoi_mesh(centers: FloatArray, shape: BaseGeometry, edge_min: float) -> tuple[np.ndarray, IntArray]:
    """Return the Voronoi cells and the restricted adjacency.

    Parameters
    ----------
    centers : (n, 2) array
        [m].
    shape : shapely polygon or multi-polygon
        Two robots are neighbors if their cells share an edge piece longer than `edge_min` inside it.
    edge_min : float
        [m].

    Returns
    -------
    cells : (n,) array of shapely.Polygon
        Not clipped.
    edges : (m, 2) int array
        Pairs of neighbors, each pair once, in ascending order.
    """
    points = np.vstack([centers, shapely.get_coordinates(shape)])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    far = FAR * max(float(np.ptp(points, axis=0).max()), 1.0)
    sites = np.vstack([centers, middle + far * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])])
    voronoi = Voronoi(sites)
    cells = np.array([_cell(voronoi, site) for site in range(len(centers))])
    pairs = []
    for pair, ridge in zip(voronoi.ridge_points, voronoi.ridge_vertices, strict=True):
        if max(pair) >= len(centers) or min(ridge) < 0:
            continue
        if shapely.LineString(voronoi.vertices[ridge]).intersection(shape).length > edge_min:
            pairs.append(sorted(int(site) for site in pair))
    return cells, np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)


def radius_ratios(triangles: FloatArray) -> FloatArray:
    """Return inscribed over circumscribed radius of (m, 3, 2) triangles, (m,); `EQUILATERAL` is the largest."""
    sides = np.sqrt(((triangles - np.roll(triangles, 1, axis=1)) ** 2).sum(axis=2))
    one, two, three = sides.T
    # With Heron's formula: r / R = (a + b - c) (b + c - a) (c + a - b) / (2 a b c).
    product = (one + two - three) * (two + three - one) * (three + one - two)
    ratios: FloatArray = product / (2.0 * one * two * three)
    return ratios


def _cell(voronoi: Voronoi, site: int) -> shapely.Polygon:
    return shapely.Polygon(voronoi.vertices[voronoi.regions[voronoi.point_region[site]]]).convex_hull


def _triangle_irregularity(centers: FloatArray, shape: BaseGeometry) -> FloatArray:
    """Return 0.5 - r_in / R_circ of the Delaunay triangles whose circumcenter is inside the shape, (m,)."""
    try:
        corners = centers[Delaunay(centers).simplices]
    except (QhullError, ValueError):  # fewer than three robots, or all on one line: there is no triangle
        return np.empty(0)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    sides = np.linalg.norm(np.stack([b - c, c - a, a - b]), axis=2)
    first, second = b - a, c - a
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]  # twice the signed area
    usable = np.abs(cross) > 1e-9 * (sides.max(axis=0) ** 2)  # slivers along a straight rim are no mesh triangles
    first, second, cross, a = first[usable], second[usable], cross[usable], a[usable]
    square_1, square_2 = (first**2).sum(axis=1), (second**2).sum(axis=1)
    offset = np.column_stack(
        [second[:, 1] * square_1 - first[:, 1] * square_2, first[:, 0] * square_2 - second[:, 0] * square_1]
    ) / (2.0 * cross[:, None])
    inside = shapely.contains_xy(shape, a + offset)
    irregularity: FloatArray = EQUILATERAL - radius_ratios(corners[usable][inside])
    return irregularity


def _cell_irregularity(cells: np.ndarray, tolerance: float) -> FloatArray:
    """Return 1 - r_in / R_enc of each clipped cell, (m,)."""
    inscribed = shapely.length(shapely.maximum_inscribed_circle(cells, tolerance=tolerance))
    irregularity: FloatArray = 1.0 - inscribed / shapely.minimum_bounding_radius(cells)
    return irregularity


def _mean(values: FloatArray) -> float | None:
    return float(values.mean()) if len(values) else None


def _variation(values: FloatArray) -> float | None:
    """Return the coefficient of variation (population), None for fewer than two values."""
    return float(values.std() / values.mean()) if len(values) > 1 and values.mean() != 0.0 else None
