"""Mesh irregularity of goals by the definitions of spec sections 14.1 and 14.2, slow and obvious, for tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import Delaunay, Voronoi
from shapely import LineString, Point, Polygon

from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True)
class MeshIrregularity:
    topological_interior: float
    topological_all: float
    geometrical: float
    area_variation: float


def mesh_irregularity(centers: FloatArray, contour: FloatArray) -> MeshIrregularity:
    shape = Polygon(contour)
    # Far sentinels make every cell of a center finite.
    middle, reach = centers.mean(axis=0), 100.0 * np.ptp(contour, axis=0).max()
    angles = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    sentinels = middle + reach * np.column_stack([np.cos(angles), np.sin(angles)])
    voronoi = Voronoi(np.concatenate([centers, sentinels]))
    neighbors = np.zeros(len(centers))
    for (i, j), ridge in zip(voronoi.ridge_points, voronoi.ridge_vertices, strict=True):
        between_centers = i < len(centers) and j < len(centers)
        if between_centers and LineString(voronoi.vertices[ridge]).intersection(shape).length > 1e-9:
            neighbors[[i, j]] += 1
    cells = [Polygon(voronoi.vertices[voronoi.regions[voronoi.point_region[i]]]) for i in range(len(centers))]
    interior = np.array([shape.contains(cell) for cell in cells])
    areas = np.array([cell.intersection(shape).area for cell in cells])
    ratios = []
    for corners in centers[Delaunay(centers).simplices]:
        circumradius, circumcenter = _circumcircle(corners)
        if shape.contains(Point(circumcenter)):
            a, b, c = (np.linalg.norm(corners[i] - corners[i - 1]) for i in range(3))
            ratios.append(2.0 * shapely.area(Polygon(corners)) / (a + b + c) / circumradius)
    return MeshIrregularity(
        topological_interior=float(np.abs(neighbors - 6)[interior].mean()),
        topological_all=float(np.abs(neighbors - 6).mean()),
        geometrical=float(0.5 - np.mean(ratios)),
        area_variation=float(areas.std() / areas.mean()),
    )


def _circumcircle(corners: FloatArray) -> tuple[float, FloatArray]:
    (ax, ay), (bx, by) = corners[1:] - corners[0]
    twice = 2.0 * (ax * by - ay * bx)
    a, b = ax * ax + ay * ay, bx * bx + by * by
    offset = np.array([by * a - ay * b, ax * b - bx * a]) / twice
    return float(np.hypot(*offset)), corners[0] + offset
