"""Centroidal Voronoi partition, computed from the shape alone, so that every robot can do it for itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter

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
# Multiples of the triangles' gain and of the radius share. With the gain, cells get better shapes and less equal areas;
# with the share, gaps get more equal.
TRADE_OFFS = ((0.7, 1.0), (1.0, 1.0), (1.3, 1.0), (1.7, 4.0), (2.0, 3.0), (0.8, 3.0))
TRADE_OFF_STEPS = 8  # from one to the next
SHARE_MAX = 1.5  # of radii in weights, whatever the multiple: more would leave small circles without a cell
BACKTRACKING = (1.0, 0.5, 0.25, 0.125, 0.06)  # shares of the way from the packing that are tried
GOOD_TOTAL = (
    6.0  # sum of the ratios of seven metrics to the packing's: one on the average a seventh better ends the search
)
UNPARTED_MAX = 10  # tessellations that are pushed in vain; where room is that tight, no other will part
SWEEPS = 100  # of pushing a tessellation apart; what needs more is in too tight a shape to stay even
RANKED_MAX = 16  # tessellations that are measured again as rounded goals
FIRST_STEPS = 2  # of a descent that is to change as little as it can: the first ones serve all metrics


class CentroidalVoronoi:
    """Partition in which every goal is near the center of its own cell, with weights that suit mixed radii.

    Hexagonal lattices, laid over the shape in several directions, settle to centroidal Voronoi tessellations; the most
    regular of them are then evened out. While they settle, the rim of the shape counts less than its inside, so that
    fewer cells lie along the contour, where they cannot have six neighbors. In the end the density is even, and a share
    of the energy asks for equilateral triangles between neighbors, which makes up for what the contour bends.

    The packing of bubbles, which every robot can compute alone as well, is one more start, and the standard that the
    result is to meet: what wins is the best mesh of those that no metric finds worse than the packing, measured as the
    goals in whole centimeters that it becomes. As the packing is no optimum of any metric, a part of the way from it to
    an even tessellation mostly is one of those where all lattices fail. The search ends with the first mesh that is
    good enough. So settings of the energy are where the search begins, and metrics decide.

    This holds where there is room to choose, as in the shapes of the library at their size. In a shape so tight that
    the circles and their gaps just fit, goals have to be pushed apart for the rounding, and what is then the least bad
    in sum may be a little worse than the packing in some metric.

    Nothing is drawn at random, and nothing but the shape, the obstacles, the radii and the settings enters. All is
    computed in a frame that turns with the shape, so a turned shape gets the turned goals up to rounding.

    How far goals are the same on all robots: with the same versions of NumPy, SciPy, GEOS and the C library they are
    the same bit for bit on all x86-64 processors, whatever vector instructions these have, as nothing on the way goes
    by BLAS, and sines are rounded (`rounding`); tests compare three kinds. With other versions, or on another
    architecture, results may differ in the last bits. As points are rounded to a micrometer where they enter the
    shape's frame and after every step, such a difference is lost unless it meets a number on the very border between
    two roundings. Then another mesh may win, and goals differ by meters; nothing here can exclude that, but robots that
    found other goals notice by the checksum in the plan. What no rounding mends is other settings or another shape:
    robots are to be given both as they are sent, in whole centimeters.

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
        packing = BubblePacking(self._bubbles)
        packed = packing.place(domain)
        contest = _Contest(domain, roomier, placed if packed is None else packed)
        self._descend(domain, contest)
        if (
            not contest.is_met
            and contest.enter(contest.reference, FINAL_SWEEPS) is None
            and (roomy := packing.place(roomier)) is not None
        ):
            contest.enter(contest.frame.enter(roomy), FINAL_SWEEPS)
        goals = contest.winner()
        return _rounded(placed) if goals is None else goals

    def _descend(self, domain: Domain, contest: _Contest) -> None:
        """Enter tessellations until one is good enough, or there are no more."""
        descents, reference = _Descents(self._config, domain, contest.shape), contest.reference
        for start in descents.lattices():
            for sites in descents.trade_offs(start):
                standing = contest.enter(sites)
                if contest.is_over:
                    return
                if standing is None or standing.is_worse_connected:
                    break
        for ways in (descents.trade_offs(reference), descents.first_steps(reference)):
            for sites in ways:
                for share in BACKTRACKING:
                    standing = contest.enter(reference + share * (sites - reference))
                    if contest.is_over:
                        return
                    if standing is not None and standing.excess == 0.0:
                        break
            if contest.is_met:
                return


class _Contest:
    """Tessellations that compete, in the frame of their shape; only those that keep all gaps when rounded take part.

    They are ranked as they are, since rounding depends on how the shape is turned. What wins has been measured again as
    the goals in whole centimeters that it becomes.

    Parameters
    ----------
    domain : Domain
    roomier : Domain
        The same with gaps that rounding may shorten.
    packed : (n, 2) array
        Goals of bubble packing, which are the standard [m].

    Attributes
    ----------
    frame : OwnFrame
    shape : shapely polygon or multi-polygon
        What is free of the shape, in its frame [m].
    reference : (n, 2) array
        The standard in the shape's frame [m].
    """

    def __init__(self, domain: Domain, roomier: Domain, packed: FloatArray) -> None:
        self.frame = OwnFrame(domain.contour)
        outlines = [Polygon(self.frame.enter(outline)) for outline in domain.obstacles]
        shape = Polygon(self.frame.enter(domain.contour)).difference(shapely.union_all(outlines))
        self.shape = shape.buffer(0.0)
        self.reference = self.frame.enter(packed)
        self._separator = Separator(roomier)
        self._comparison = MeshComparison(self.shape, domain.radii, self.reference)
        self._entries: list[_Entry] = []
        self._unparted = 0

    @property
    def is_met(self) -> bool:
        """Whether some goals are not worse than the standard in any metric."""
        return any(entry.meets for entry in self._entries)

    @property
    def is_over(self) -> bool:
        """Whether goals that meet the standard are so much better on the whole that it is enough, or room is tight."""
        return self._unparted >= UNPARTED_MAX or any(
            entry.standing.total <= GOOD_TOTAL and entry.meets for entry in self._entries
        )

    def enter(self, sites: FloatArray, sweeps: int = SWEEPS) -> Standing | None:
        """Take (n, 2) sites after sweeps of pushing them apart; None if these did not get them apart."""
        centers = self._separator.apart(self.frame.leave(sites), sweeps)
        if not self._separator.is_separated(centers):
            self._unparted += 1
            return None
        standing = self._comparison.standing(self.frame.enter(centers))
        self._entries.append(_Entry(standing, _rounded(centers), self))
        return standing

    def winner(self) -> FloatArray | None:
        """Return the best goals in whole centimeters, (n, 2); None if none keep the gaps."""
        ranked = sorted(self._entries, key=attrgetter("standing"))[:RANKED_MAX]
        met = next((entry for entry in ranked if entry.meets), None)
        best = met or min(ranked, key=attrgetter("excess_rounded"), default=None)
        return None if best is None else best.goals

    def excess(self, goals: FloatArray) -> float:
        """Return by how much goals are worse than the standard, 0 if in no metric."""
        return self._comparison.standing(self.frame.enter(goals), margin=0.0).excess


@dataclass(eq=False)
class _Entry:
    """Goals that take part, and how they stand before they were rounded."""

    standing: Standing
    goals: FloatArray
    contest: _Contest

    @property
    def meets(self) -> bool:
        """Whether they are not worse than the standard in any metric, before and after they were rounded."""
        return self.standing.excess == 0.0 and self.excess_rounded == 0.0

    @cached_property
    def excess_rounded(self) -> float:
        """By how much they are worse than the standard as they are."""
        return self.contest.excess(self.goals)


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
        filled.sort(key=even.irregularity)
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


def _rounded(centers: FloatArray) -> FloatArray:
    return centers.round(DECIMALS) + 0.0  # no negative zeros


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
