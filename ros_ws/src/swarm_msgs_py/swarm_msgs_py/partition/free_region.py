"""Where the center of a circle may be, and the nearest such point."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.types import FloatArray

ARC_SEGMENTS = 16  # chords per quarter circle
# GEOS simplifies a polygon by up to 1 % of the distance before it buffers it; chords for arcs cut off another 0.12 %.
BUFFER_ERROR = 0.0115


class FreeRegion:
    """A set of points bounded by straight segments: one or more pieces, with holes or none.

    Parameters
    ----------
    geometry : shapely polygon or multi-polygon
        The region.
    """

    def __init__(self, geometry: BaseGeometry) -> None:
        rings = [
            np.asarray(ring.coords, dtype=np.float64)
            for part in shapely.get_parts(geometry)
            if isinstance(part, Polygon) and part.area > 0.0
            for ring in (part.exterior, *part.interiors)
        ]
        self.starts: FloatArray = np.concatenate([ring[:-1] for ring in rings]) if rings else np.empty((0, 2))
        self.ends: FloatArray = np.concatenate([ring[1:] for ring in rings]) if rings else np.empty((0, 2))
        self._edges = self.ends - self.starts
        self._squares = np.einsum("md,md->m", self._edges, self._edges)
        self._low, self._high = self.starts[:, 1].copy(), self.ends[:, 1].copy()
        # Horizontal edges never straddle a ray along +x, so what is divided by for them does not count.
        rise = np.where(self._high == self._low, 1.0, self._high - self._low)
        self._west, self._slopes = self.starts[:, 0].copy(), self._edges[:, 0] / rise

    @property
    def is_empty(self) -> bool:
        """Whether the region has no point."""
        return not len(self.starts)

    def contains(self, points: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        """Return whether each of (n, 2) points is inside, by counting crossings of a ray along +x.

        Points on the boundary may fall either way.
        """
        x, y = points[:, :1], points[:, 1:]
        straddles = (self._low > y) != (self._high > y)
        crossing = self._west + (y - self._low) * self._slopes
        inside: np.ndarray[tuple[int], np.dtype[np.bool_]] = np.logical_xor.reduce(straddles & (x < crossing), axis=1)
        return inside

    def feet(self, point: FloatArray) -> FloatArray:
        """Return the point of each boundary segment that is nearest to `point`, (m, 2)."""
        along = np.clip(((point - self.starts) * self._edges).sum(axis=1) / self._squares, 0.0, 1.0)
        feet: FloatArray = self.starts + along[:, None] * self._edges
        return feet

    def nearest(self, point: FloatArray) -> FloatArray:
        """Return the point of a region that is not empty that is nearest to `point`, (2,): `project` for one point."""
        if self.contains(point[None])[0]:
            return point
        gaps = point - self.feet(point)
        nearest: FloatArray = point - gaps[(gaps[:, 0] * gaps[:, 0] + gaps[:, 1] * gaps[:, 1]).argmin()]
        return nearest

    def project(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points of the region, and how far each is from the boundary.

        Parameters
        ----------
        points : (n, 2) array

        Returns
        -------
        (n, 2) array
            Points inside unchanged, points outside moved to the nearest boundary point.
        (n,) array
            Distance to the boundary [m], 0 for those that were moved.
        """
        offsets = points[:, None] - self.starts
        along = np.clip(np.einsum("nmd,md->nm", offsets, self._edges) / self._squares, 0.0, 1.0)
        gaps = offsets - along[:, :, None] * self._edges
        squares = np.einsum("nmd,nmd->nm", gaps, gaps)
        nearest = np.argmin(squares, axis=1)
        rows = np.arange(len(points))
        inside = self.contains(points)
        moved = np.where(inside[:, None], points, points - gaps[rows, nearest])
        return moved, np.where(inside, np.sqrt(squares[rows, nearest]), 0.0)


def free_region(
    contour: FloatArray, obstacles: tuple[FloatArray, ...], radius: float, contour_gap: float, obstacle_gap: float
) -> FreeRegion:
    """Return where the center of a circle may be, ready to be asked about points; parameters as `free_polygon`."""
    return FreeRegion(free_polygon(contour, obstacles, radius, contour_gap, obstacle_gap))


def free_polygon(
    contour: FloatArray, obstacles: tuple[FloatArray, ...], radius: float, contour_gap: float, obstacle_gap: float
) -> BaseGeometry:
    """Return where the center of a circle may be (first half of Algorithm 1 of the thesis).

    Parameters
    ----------
    contour : (k, 2) array
        Shape [m].
    obstacles : tuple of (m, 2) array
        Polygons [m].
    radius : float
        Of the circle [m].
    contour_gap, obstacle_gap : float
        Free gap to keep to the contour and to obstacles [m].
    """
    region = Polygon(contour).buffer(-(radius + contour_gap) * (1.0 + BUFFER_ERROR), quad_segs=ARC_SEGMENTS)
    reach = (radius + obstacle_gap) * (1.0 + BUFFER_ERROR)
    for outline in obstacles:
        obstacle = Polygon(outline)
        if obstacle.distance(region) < reach:
            region = region.difference(obstacle.buffer(reach, quad_segs=ARC_SEGMENTS))
    return region
