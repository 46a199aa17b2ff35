"""Centroidal Voronoi partition, computed from the shape alone, so that every robot can do it for itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from operator import itemgetter

import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.config import BubbleConfig, VoronoiConfig
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.initial_placement import place, shortage
from swarm_msgs_py.partition.lattice_starts import lattice_starts
from swarm_msgs_py.partition.mesh_comparison import MeshComparison, Standing
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.partition.spreading import spread_sizes
from swarm_msgs_py.types import FloatArray

DECIMALS = 2  # goals are in whole centimeters, as plans travel
ROUNDING_M = 0.0071  # half the diagonal of a centimeter: so far may rounding move a goal
STEP_MAX = 0.3  # of the minimizer, in spacings; longer ones would jump between lattices
DECIMALS_COMPARED = 9  # of irregularities, so that last bits decide nothing between what is equal by symmetry
# Multiples of the triangles' gain and of the radius share. With the gain, cells get better shapes and less equal areas;
# with the share, gaps get more equal.
TRADE_OFFS = ((0.7, 1.0), (1.0, 1.0), (1.3, 1.0), (1.7, 4.0), (2.0, 3.0), (0.8, 3.0))
TRADE_OFF_STEPS = 8  # from one to the next
SHARE_MAX = 1.5  # of radii in weights, whatever the multiple: more would leave small circles without a cell
BACKTRACKING = (1.0, 0.5, 0.25, 0.125)  # shares of the way from the packing that are tried
FIRST_STEPS = 2  # of a descent that is to change as little as it can: the first ones serve all metrics


class CentroidalVoronoi:
    """Partition in which every goal is near the center of its own cell, with weights that suit mixed radii.

    Hexagonal lattices, laid over the shape in several directions, settle to centroidal Voronoi tessellations; the most
    regular of them are then evened out. While they settle, the rim of the shape counts less than its inside, so that
    fewer cells lie along the contour, where they cannot have six neighbors. In the end the density is even, and a share
    of the energy asks for equilateral triangles between neighbors, which makes up for what the contour bends.

    The packing of bubbles, which every robot can compute alone as well, is one more start, and the standard that the
    result is to meet: what wins is the best mesh of those that no metric finds worse than the packing. As the packing
    is no optimum of any of them, a part of the way from it to an even tessellation mostly is one of those where all
    lattices fail; if nothing is, the packing itself may win. So settings of the energy are where the search
    begins, and metrics decide.

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
    bubbles : BubbleConfig or None
        Tuning of the packing; None for the defaults.

    References
    ----------
    .. [1] Q. Du, V. Faber, M. Gunzburger, "Centroidal Voronoi tessellations: applications and algorithms", SIAM
       Review 41(4), 1999.
    .. [2] F. Aurenhammer, "Power diagrams: properties, algorithms and applications", SIAM J. Computing 16(1), 1987.
    """

    def __init__(self, config: VoronoiConfig, bubbles: BubbleConfig | None = None) -> None:
        self._config = config
        self._bubbles = bubbles or BubbleConfig()

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the circle for which Algorithm 1 finds no room besides what rounding takes, None if it places all."""
        return shortage(_roomier(domain))

    def place(self, domain: Domain) -> FloatArray | None:
        """Return (n, 2) centers in whole centimeters, which keep all gaps; None if Algorithm 1 finds no room."""
        roomier = _roomier(domain)
        placed = place(roomier)
        if placed is None:
            return None
        centers = self._settle(domain, placed)
        if not Separator(roomier).is_separated(centers):
            centers = placed
        return centers.round(DECIMALS) + 0.0  # no negative zeros

    def _settle(self, domain: Domain, placed: FloatArray) -> FloatArray:
        """Return the sites of the best tessellation after they were pushed apart, as far as that got."""
        frame, separator = OwnFrame(domain.contour), Separator(_roomier(domain))
        packed = BubblePacking(self._bubbles).place(domain)
        reference = frame.enter(placed if packed is None else packed)
        outlines = tuple(frame.enter(outline) for outline in domain.obstacles)
        shape = Polygon(frame.enter(domain.contour)).difference(shapely.union_all([Polygon(o) for o in outlines]))
        shape = shape.buffer(0.0)
        comparison = MeshComparison(shape, domain.radii, reference)
        found: list[tuple[Standing, FloatArray]] = []

        def judged(sites: FloatArray) -> Standing:
            centers = separator.apart(frame.leave(sites), FINAL_SWEEPS)
            standing = comparison.standing(frame.enter(centers))
            found.append((standing, centers))
            return standing

        descents = _Descents(self._config, domain, shape)
        for start in descents.lattices():
            for sites in descents.trade_offs(start):
                if judged(sites).is_worse_connected:
                    break
        for ways in (descents.trade_offs(reference), descents.first_steps(reference)):
            for sites in ways:
                for share in BACKTRACKING:
                    if judged(reference + share * (sites - reference)).excess == 0.0:
                        break
            if min(standing for standing, _ in found).excess == 0.0:
                break
        else:
            judged(reference)
        return min(found, key=itemgetter(0))[1]


class _Descents:
    """Ways down to even tessellations of a shape.

    Parameters
    ----------
    config : VoronoiConfig
    domain : Domain
        What radii the circles have, and in which order.
    shape : shapely polygon or multi-polygon
        What is free of the shape, in its own frame [m].
    """

    def __init__(self, config: VoronoiConfig, domain: Domain, shape: BaseGeometry) -> None:
        self._config = config
        self._domain = domain
        self._shape = shape
        self._region = Region(shape)

    def lattices(self) -> list[FloatArray]:
        """Return the most regular of the tessellations to which hexagonal lattices settle with a light rim."""
        config, domain, shape = self._config, self._domain, self._shape
        core = shape.buffer(-config.rim_width * domain.spacing)
        region = Region(shape, core, config.core_density)
        energy = MeshEnergy(region, shape.area, self._weights(1.0), 0.0)
        starts = lattice_starts(shape, domain.spacing, len(domain.radii), config.starts)
        settled = [self._down(energy, spread_sizes(domain, start), config.start_steps) for start in starts]
        filled = [sites for sites in settled if not energy.has_empty_cell(sites)]
        even = self._even(1.0, 1.0)
        filled.sort(key=lambda sites: round(even.irregularity(sites), DECIMALS_COMPARED))
        return filled[: config.finalists]

    def trade_offs(self, start: FloatArray) -> Iterator[FloatArray]:
        """Yield what a start settles to at an even density, for one trade-off between the metrics after the other."""
        sites, steps = start, self._config.steps_max
        for gain, share in TRADE_OFFS:
            sites = self._down(self._even(gain, share), sites, steps)
            steps = TRADE_OFF_STEPS
            yield sites

    def first_steps(self, start: FloatArray) -> Iterator[FloatArray]:
        """Yield where the first steps from a start lead, one for every trade-off."""
        for gain, share in TRADE_OFFS:
            yield self._down(self._even(gain, share), start, FIRST_STEPS)

    def _even(self, gain: float, share: float) -> MeshEnergy:
        return MeshEnergy(self._region, self._shape.area, self._weights(share), gain * self._config.triangle_gain)

    def _weights(self, share: float) -> FloatArray:
        weights: FloatArray = (
            min(share * self._config.radius_share, SHARE_MAX) * self._domain.spacing * self._domain.radii
        )
        return weights

    def _down(self, energy: MeshEnergy, start: FloatArray, steps_max: int) -> FloatArray:
        step_max = STEP_MAX * self._domain.spacing
        return minimize(energy, start, step_max=step_max, tolerance=self._config.tolerance_m, steps_max=steps_max)


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
