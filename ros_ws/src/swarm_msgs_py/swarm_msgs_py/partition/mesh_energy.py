"""How uneven a set of sites fills a region, as an energy to be lowered and as a number to choose by."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.geometry.mesh_quality import EDGE_MIN, EQUILATERAL, HEXAGON, radius_ratios
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.power_diagram import PowerDiagram
from swarm_msgs_py.partition.rounding import on_grid
from swarm_msgs_py.types import FloatArray, IntArray

SLIVER = 1e-6  # triangles with less area than this part of a cell are no part of the mesh
SQUARES_PER_AREA = 4.0 * math.sqrt(3.0)  # sum of squared sides over area of an equilateral triangle
# Weights in `irregularity`, that of inner cells' neighbor counts being 1: no share may lose what another gains.
TRIANGLE_WEIGHT = 20.0
AREA_WEIGHT = 3.0
DECIMALS = 9  # of irregularities, so that last bits decide nothing between what is equal by symmetry


class MeshEnergy:
    """Energy of a centroidal power diagram, with a share for the shapes of the dual triangles.

    The energy is the sum over cells of the integral of density times the power distance to the site, and over
    triangles of the excess of their squared sides per area over that of an equilateral one. It is divided by the mean
    area, so that a site's first step along the gradient is Lloyd's, to the center of its cell.

    Parameters
    ----------
    region : Region
        What to fill.
    area : float
        Of the region [m^2].
    weights : (n,) array
        Of the power diagram [m^2].
    triangle_gain : float
        Share of the triangles; 0: the plain centroidal diagram, 1: a triangle counts about as much as a cell.
    """

    def __init__(self, region: Region, area: float, weights: FloatArray, triangle_gain: float) -> None:
        self._region = region
        self._cell_area = area / len(weights)
        self._weights = weights
        self._triangle_gain = triangle_gain

    def __call__(self, sites: FloatArray) -> tuple[float, FloatArray]:
        """Return the energy of (n, 2) sites [m^2] and its gradient, (n, 2) [m]."""
        diagram = self._diagram(sites)
        cells = self._region.moments(diagram)
        # Less the weights, since else the energy would change with the borders between cells.
        powers = cells.energies - self._weights * cells.areas
        energies = [0.5 * math.fsum(powers.tolist()) / self._cell_area]
        gradient = (cells.areas[:, None] * sites - cells.firsts) / self._cell_area
        if self._triangle_gain:
            excess, slopes = self._triangle_excess(diagram)
            gain = 0.5 * self._triangle_gain * self._cell_area
            energies.append(gain * math.fsum(excess.tolist()))
            gradient += gain * slopes
        return math.fsum(energies), gradient

    def has_empty_cell(self, sites: FloatArray) -> bool:
        """Return whether some site has no part of the region, where no slope would ever move it."""
        return bool((self._region.moments(self._diagram(sites)).areas <= 0.0).any())

    def irregularity(self, sites: FloatArray, all_weight: float = 1.0) -> float:
        """Return a weighted sum of the topological irregularities, the geometrical one, and the variation of areas.

        Parameters
        ----------
        sites : (n, 2) array
            [m].
        all_weight : float
            Of the topological irregularity of all cells, that of inner cells having the weight 1; the larger, the fewer
            cells along the contour.

        References
        ----------
        .. [1] Thesis eqs. (3.104) and (3.106); neighbors are cells that share an edge inside the region.
        """
        diagram = self._diagram(sites)
        lengths = self._region.lengths_inside(diagram)
        is_edge = (lengths > EDGE_MIN * math.sqrt(self._cell_area)) & (diagram.pairs < diagram.count).all(axis=1)
        neighbors = np.bincount(diagram.pairs[is_edge].ravel(), minlength=diagram.count)
        deviation = np.abs(neighbors - HEXAGON)
        cells = self._region.moments(diagram)
        inner = deviation[~cells.touching]
        ratios = radius_ratios(sites[self._inner_triangles(diagram)])
        irregularity = (
            all_weight * float(deviation.mean())
            + (float(inner.mean()) if len(inner) else 0.0)
            + (TRIANGLE_WEIGHT * float((EQUILATERAL - ratios).mean()) if len(ratios) else 0.0)
            + AREA_WEIGHT * float(cells.areas.std() / cells.areas.mean())
        )
        return round(irregularity, DECIMALS)

    def largest_hole(self, sites: FloatArray, apart_from: int) -> FloatArray | None:
        """Return the point of the region farthest from all sites, of those where three cells meet, (2,); None: no such.

        Points where the cell of the site `apart_from` is one of the three do not count.
        """
        diagram = self._diagram(sites)
        usable = self._region.contains(diagram.centers) & (diagram.triangles != apart_from).all(axis=1)
        if not usable.any():
            return None
        centers, corners = diagram.centers[usable], sites[diagram.triangles[usable, 0]]
        farthest: FloatArray = centers[np.argmax(on_grid(((centers - corners) ** 2).sum(axis=1)))]
        return farthest

    def _diagram(self, sites: FloatArray) -> PowerDiagram:
        return PowerDiagram(sites, self._weights, self._region.far)

    def _inner_triangles(self, diagram: PowerDiagram) -> IntArray:
        """Return the triangles whose cells meet inside the region: the others only close the hull."""
        triangles: IntArray = diagram.triangles[self._region.contains(diagram.centers)]
        return triangles

    def _triangle_excess(self, diagram: PowerDiagram) -> tuple[FloatArray, FloatArray]:
        """Return squared sides per area, over that of an equilateral triangle less 1, and its slopes at the sites."""
        triangles = self._inner_triangles(diagram)
        corners = diagram.sites[triangles]
        one, two, three = corners[:, 0], corners[:, 1], corners[:, 2]
        double = (two - one)[:, 0] * (three - one)[:, 1] - (two - one)[:, 1] * (three - one)[:, 0]
        usable = np.abs(double) > SLIVER * self._cell_area
        triangles, corners, double = triangles[usable], corners[usable], double[usable]
        areas, turns = 0.5 * np.abs(double), np.where(double > 0.0, 0.5, -0.5)
        squares = np.zeros(len(triangles))
        for corner in range(3):
            side = corners[:, corner] - corners[:, corner - 1]
            squares += side[:, 0] ** 2 + side[:, 1] ** 2
        ratios = squares / (SQUARES_PER_AREA * areas)
        slopes = np.zeros((diagram.count, 2))
        for corner in range(3):
            here, after, before = corners[:, corner], corners[:, (corner + 1) % 3], corners[:, corner - 1]
            growth = 2.0 * (2.0 * here - after - before)
            across = turns[:, None] * np.column_stack([(after - before)[:, 1], (before - after)[:, 0]])
            slope = growth / (SQUARES_PER_AREA * areas)[:, None] - (ratios / areas)[:, None] * across
            for axis in range(2):
                slopes[:, axis] += np.bincount(triangles[:, corner], slope[:, axis], diagram.count)
        return ratios - 1.0, slopes
