"""Areas, centers and energies of the cells of a power diagram inside a region that need not be convex.

A cell's moments are integrals along its boundary (Green), and that boundary is made of pieces of two kinds: pieces of
the straight edges between cells, as far as they are inside the region, and pieces of the region's contour, as far as
they are inside the cell. Neither needs the cells as polygons: the cost is a handful of array operations where clipping
polygons one by one takes several times as long, and holes or cells in several parts are no special cases.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.partition.power_diagram import PowerDiagram
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

FAR = 8.0  # auxiliary sites of the diagrams stand this many extents of the region away
POINT = 1e-12  # [m^2]; squared length of an edge that is a point up to rounding


@dataclass(frozen=True, slots=True, eq=False)
class CellMoments:
    """Moments of the cells inside the region.

    Attributes
    ----------
    areas : (n,) array
        Times density; 0 for a site that has no cell [m^2].
    firsts : (n, 2) array
        First moments: area times center of area [m^3].
    energies : (n,) array
        Integral of the squared distance to the site, what Lloyd's iteration lowers [m^4].
    touching : (n,) bool array
        Whether the cell reaches the contour of the region.
    """

    areas: FloatArray
    firsts: FloatArray
    energies: FloatArray
    touching: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """Straight pieces of cell boundaries, each with the cell that it bounds; `signs` is -1 for those to take away."""

    owners: IntArray
    starts: FloatArray
    ends: FloatArray
    signs: FloatArray


class Region:
    """Points inside polygons and outside their holes, as directed boundary edges with the inside on their left.

    Parameters
    ----------
    geometry : shapely polygon or multi-polygon
        Near the origin, where moments would cancel.
    core : shapely geometry or None
        A part of it that is denser; it may be empty.
    core_density : float
        What the core has beyond the density 1 of the whole region. Where the density changes there is one more contour,
        with the change for a weight.
    """

    def __init__(self, geometry: BaseGeometry, core: BaseGeometry | None = None, core_density: float = 0.0) -> None:
        outer, inner = _rings(geometry), [] if core is None else _rings(core)
        rings = outer + inner
        sizes = [len(ring) for ring in rings]
        begins = np.cumsum([0, *sizes])
        self._vertices: FloatArray = np.concatenate(rings)
        self._next: IntArray = np.concatenate(
            [begin + np.roll(np.arange(size), -1) for begin, size in zip(begins[:-1], sizes, strict=True)]
        )
        self._edges = self._vertices[self._next] - self._vertices
        self._outer = int(begins[len(outer)])  # the vertices up to here are on the contour of the region itself
        self._steps: FloatArray = np.where(np.arange(len(self._vertices)) < self._outer, 1.0, core_density)
        self.far = FAR * float(np.abs(self._vertices).max())

    def contains(self, points: FloatArray) -> BoolArray:
        """Return whether each of (m, 2) points is inside, by counting the edges that cross a ray along +x."""
        x, y = points[:, :1], points[:, 1:]
        vertices, (run, rise) = self._vertices[: self._outer], self._edges[: self._outer].T
        above = vertices[:, 1] > y
        straddles = above != above[:, self._next[: self._outer]]
        crossing = vertices[:, 0] + (y - vertices[:, 1]) * (run / np.where(rise == 0.0, 1.0, rise))
        inside: BoolArray = np.count_nonzero(straddles & (x < crossing), axis=1) % 2 == 1
        return inside

    def lengths_inside(self, diagram: PowerDiagram) -> FloatArray:
        """Return how long the part of each edge of the diagram inside the region is, (m,) [m]."""
        edge, contour, along, signs = self._crossings(diagram)
        steps = diagram.ends - diagram.starts
        lengths = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
        inside: FloatArray = np.bincount(edge, signs * along * (contour < self._outer), len(lengths)) * lengths
        return inside

    def moments(self, diagram: PowerDiagram) -> CellMoments:
        """Return the moments of the diagram's cells, clipped to the region and weighted with its density."""
        count = diagram.count
        along_contour, touching = self._along_contour(diagram)
        areas, firsts, seconds = np.zeros(count), np.zeros((count, 2)), np.zeros(count)
        for pieces in (self._between_cells(diagram), along_contour):
            (x, y), (u, v) = pieces.starts.T, pieces.ends.T
            # Area, first and second moment of the triangle between the origin and a piece.
            cross = pieces.signs * (x * v - y * u)
            areas += np.bincount(pieces.owners, cross, count)[:count] / 2.0
            firsts[:, 0] += np.bincount(pieces.owners, cross * (x + u), count)[:count] / 6.0
            firsts[:, 1] += np.bincount(pieces.owners, cross * (y + v), count)[:count] / 6.0
            squares = x * (x + u) + u * u + y * (y + v) + v * v
            seconds += np.bincount(pieces.owners, cross * squares, count)[:count] / 12.0
        x, y = diagram.sites[:count].T
        energies = seconds - 2.0 * (x * firsts[:, 0] + y * firsts[:, 1]) + areas * (x * x + y * y)
        return CellMoments(np.maximum(areas, 0.0), firsts, energies, touching)

    def _crossings(self, diagram: PowerDiagram) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Return where lines of the diagram's edges cross contours: edge, vertex before, position, way out or in.

        Positions run from 0 to 1 along the edge, and crossings beyond its ends are clamped to them. What an edge has
        inside is then the sum over its line's ways out (+1) less the sum over its ways in (-1): there is nothing to
        sort, and as every vertex is on one side of the line or the other, none can be crossed twice or not at all.
        """
        starts, steps = diagram.starts, diagram.ends - diagram.starts
        x, y = self._vertices.T
        left = steps[:, :1] * (y - starts[:, 1:]) - steps[:, 1:] * (x - starts[:, :1])
        is_left = left >= 0.0
        edge, contour = np.nonzero(is_left != is_left[:, self._next])
        before, after = left[edge, contour], left[edge, self._next[contour]]
        offsets = self._vertices[contour] - starts[edge] + (before / (before - after))[:, None] * self._edges[contour]
        steps = steps[edge]
        squares = np.maximum(steps[:, 0] ** 2 + steps[:, 1] ** 2, POINT)
        along = (offsets[:, 0] * steps[:, 0] + offsets[:, 1] * steps[:, 1]) / squares
        # Where the contour turns to the left of the line, the inside, on its own left, is behind.
        return edge, contour, np.minimum(np.maximum(along, 0.0), 1.0), np.where(before < 0.0, 1.0, -1.0)

    def _between_cells(self, diagram: PowerDiagram) -> _Pieces:
        """Return the pieces between cells, from the start of each edge to every crossing, once for each of the two."""
        edge, contour, along, signs = self._crossings(diagram)
        signs *= self._steps[contour]
        starts = diagram.starts[edge]
        ends = starts + along[:, None] * (diagram.ends[edge] - starts)
        owners, others = diagram.pairs[edge].T
        return _Pieces(
            np.concatenate([owners, others]),
            np.concatenate([starts, starts]),
            np.concatenate([ends, ends]),
            np.concatenate([signs, -signs]),
        )

    def _along_contour(self, diagram: PowerDiagram) -> tuple[_Pieces, BoolArray]:
        """Return the pieces of the contours, and whose cells reach the region's own, (n,).

        A cell is where no neighbor is nearer, on each edge of a contour one interval.
        """
        both = np.concatenate([diagram.pairs, diagram.pairs[:, ::-1]])
        both = both[both[:, 0] < diagram.count]
        owners, others = both[np.argsort(both[:, 0], kind="stable")].T
        normals = 2.0 * (diagram.sites[others] - diagram.sites[owners])
        x, y = self._vertices.T
        # How much nearer the neighbor is than the owner, at each vertex of the contour.
        lack = normals[:, :1] * x + normals[:, 1:] * y - (diagram.lifted[others] - diagram.lifted[owners])[:, None]
        beyond = lack > 0.0
        blocks = np.flatnonzero(np.diff(owners, prepend=-1))  # where the neighbors of each owner begin
        sizes = np.diff(blocks, append=len(owners))
        missed = np.logical_or.reduceat(beyond & beyond[:, self._next], blocks, axis=0)
        cell, contour = np.nonzero(~missed)  # no neighbor has the whole edge: few are left
        begins = np.cumsum(sizes[cell]) - sizes[cell]
        rows = np.arange(int(sizes[cell].sum())) + np.repeat(blocks[cell] - begins, sizes[cell])
        columns = np.repeat(contour, sizes[cell])
        before, after = lack[rows, columns], lack[rows, self._next[columns]]
        rise = after - before
        crossing = -before / np.where(rise == 0.0, 1.0, rise)
        low = np.maximum.reduceat(np.where(before > 0.0, crossing, 0.0), begins)
        high = np.minimum.reduceat(np.where(after > 0.0, crossing, 1.0), begins)
        kept = low < high
        cell, contour, low, high = cell[kept], contour[kept], low[kept], high[kept]
        origins, edges = self._vertices[contour], self._edges[contour]
        cells = owners[blocks][cell]
        touching = np.bincount(cells[contour < self._outer], minlength=diagram.count) > 0
        starts, ends = origins + low[:, None] * edges, origins + high[:, None] * edges
        return _Pieces(cells, starts, ends, self._steps[contour]), touching


def _rings(geometry: BaseGeometry) -> list[FloatArray]:
    """Return the boundaries of all parts, (k, 2) each, outer ones counter-clockwise and holes clockwise."""
    rings = []
    for part in shapely.get_parts(geometry):
        if isinstance(part, shapely.Polygon) and part.area > 0.0:
            directed = shapely.geometry.polygon.orient(part)
            rings += [np.asarray(ring.coords)[:-1] for ring in (directed.exterior, *directed.interiors)]
    return rings
