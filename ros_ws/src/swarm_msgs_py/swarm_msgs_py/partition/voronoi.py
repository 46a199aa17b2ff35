"""Centroidal Voronoi partition, computed from the shape alone, so that every robot can do it for itself."""

from __future__ import annotations

from dataclasses import replace

import shapely
from shapely import Polygon

from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.config import VoronoiConfig
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.initial_placement import place, shortage
from swarm_msgs_py.partition.lattice_starts import lattice_starts
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.partition.spreading import spread_sizes
from swarm_msgs_py.types import FloatArray

DECIMALS = 2  # goals are in whole centimeters, as plans travel
ROUNDING_M = 0.0071  # half the diagonal of a centimeter: so far may rounding move a goal
STEP_MAX = 0.3  # of the minimizer, in spacings; longer ones would jump between lattices


class CentroidalVoronoi:
    """Partition in which every goal is near the center of its own cell, with weights that suit mixed radii.

    Hexagonal lattices, laid over the shape in several directions, settle to centroidal Voronoi tessellations; the most
    regular of them is then evened out. While they settle, the rim of the shape counts less than its inside, so that
    fewer cells lie along the contour, where they cannot have six neighbors. In the end the density is even, and a share
    of the energy asks for equilateral triangles between neighbors, which makes up for what the contour bends.

    Nothing is drawn at random, and nothing but the shape, the obstacles, the radii and the settings enters. All is
    computed in a frame that turns with the shape, so a turned shape gets the turned goals up to rounding.

    How far goals are the same on all robots: with the same versions of NumPy, SciPy and GEOS on the same kind of
    processor they are the same bit for bit. Elsewhere results may differ in the last bits. As points are rounded to a
    micrometer after every step and to a centimeter in the end, such a difference is lost unless it meets a number on
    the very border between two roundings; it would then move that goal by a centimeter or, early on, let another
    lattice win, which nothing here can exclude. What no rounding mends is other settings or another shape: robots are
    to be given both as they are sent, in whole centimeters.

    Parameters
    ----------
    config : VoronoiConfig
        Tuning.

    References
    ----------
    .. [1] Q. Du, V. Faber, M. Gunzburger, "Centroidal Voronoi tessellations: applications and algorithms", SIAM
       Review 41(4), 1999.
    .. [2] F. Aurenhammer, "Power diagrams: properties, algorithms and applications", SIAM J. Computing 16(1), 1987.
    """

    def __init__(self, config: VoronoiConfig) -> None:
        self._config = config

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the circle for which Algorithm 1 finds no room besides what rounding takes, None if it places all."""
        return shortage(_roomier(domain))

    def place(self, domain: Domain) -> FloatArray | None:
        """Return (n, 2) centers in whole centimeters, which keep all gaps; None if Algorithm 1 finds no room."""
        roomier = _roomier(domain)
        placed = place(roomier)
        if placed is None:
            return None
        separator = Separator(roomier)
        centers = separator.apart(self._settle(domain, placed), FINAL_SWEEPS)
        if not separator.is_separated(centers):
            centers = placed
        return centers.round(DECIMALS) + 0.0  # no negative zeros

    def _settle(self, domain: Domain, placed: FloatArray) -> FloatArray:
        """Return the sites of the most regular tessellation, which need not keep any gap."""
        config, frame = self._config, OwnFrame(domain.contour)
        outlines = tuple(frame.enter(outline) for outline in domain.obstacles)
        shape = Polygon(frame.enter(domain.contour)).difference(shapely.union_all([Polygon(o) for o in outlines]))
        shape = shape.buffer(0.0)
        spacing, count = domain.spacing, len(domain.radii)
        weights = config.radius_share * spacing * domain.radii
        core = shape.buffer(-config.rim_width * spacing)
        first = MeshEnergy(Region(shape, core, config.core_density), shape.area, weights, 0.0)
        last = MeshEnergy(Region(shape), shape.area, weights, config.triangle_gain)
        step_max = STEP_MAX * spacing

        def settled(start: FloatArray, energy: MeshEnergy, steps_max: int) -> FloatArray:
            return minimize(energy, start, step_max=step_max, tolerance=config.tolerance_m, steps_max=steps_max)

        starts = [spread_sizes(domain, start) for start in lattice_starts(shape, spacing, count, config.starts)]
        rough = [settled(start, first, config.start_steps) for start in starts]
        rough = [sites for sites in rough if not first.has_empty_cell(sites)] or [frame.enter(placed)]
        rough.sort(key=last.irregularity)
        fine = [settled(sites, last, config.steps_max) for sites in rough[: config.finalists]]
        return frame.leave(min(fine, key=last.irregularity))


def _roomier(domain: Domain) -> Domain:
    """Return the problem with gaps that rounding may shorten."""
    gaps = domain.gaps
    wider = replace(
        gaps,
        robot_m=gaps.robot_m + 2.0 * ROUNDING_M,
        contour_m=gaps.contour_m + ROUNDING_M,
        obstacle_m=gaps.obstacle_m + ROUNDING_M,
    )
    return replace(domain, gaps=wider)
