"""Goals on the way from one shape to another: the partition goes on from where it is while the contour moves.

Goals take part in the motion that most of the contour shares, and settle by the law of the method that made them. They
follow with a little play, so that those far from a change, which would creep along by centimeters, stay at rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import shapely
from shapely import Polygon

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.morphing import Morph
from swarm_msgs_py.partition.bubble_packing import Packing
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.config import Gaps, Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.partitioning import GoalSet
from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.partition.voronoi import DECIMALS, ROUNDING_M, STEP_MAX
from swarm_msgs_py.partition.ways import Ways
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import BoolArray, FloatArray

KNOT_S = 5.0  # goals are told at least this often, as far as `KNOTS_MAX` goes; between knots they are interpolated
KNOTS_MIN = 8
KNOTS_MAX = 64
"""Knots that a track may have: more than five minutes of motion have knots less often."""
FOUND_MAX = 50 * KNOTS_MAX
"""Robots times knots of a track that robots find for themselves. That takes them less than a minute: most with bubble
packing for many robots (its time grows with their square)."""
STEPS = 8  # of the contour from knot to knot
AHEAD = 3  # steps by which the contour for which goals settle is ahead: packing follows a contour late
ITERATIONS = 60  # of bubble packing after each of them: at least 40 per 0.5 s of motion (spec 13)
DESCENTS = 4  # steps of the Voronoi descent after each of them
PUSHES = 30  # iterations of bubble packing before them, while all of a lattice is to flow: rows would resist
SOFTNESS = 1.0 / 3.0  # share of the triangles' gain meanwhile: stiff triangles would not let it
REACH = 3.0  # [spacings]; goals farther from where the contour changes stay at rest
SWEEPS = 50  # of pushing goals apart after each step; the next one goes on where they end
PLAY = 0.02  # [spacings]; goals that would move less stay where they are
PLAY_LEFT = 0.8  # share of its play that is left to a goal after each step in which it moved
SMOOTHINGS = 2  # of the goals' ways in time: goals that change places in the mesh would do so at a jump
GAP_MIN_M = 0.01  # what `Gaps` allows at least


@dataclass(frozen=True, slots=True, eq=False)
class Relaxing:
    """A step of the contour, after which goals settle.

    Attributes
    ----------
    domain : Domain
        Where goals may be.
    config : PartitionConfig
        Tuning of the law.
    free : (n,) bool array
        Goals that may move; the others are where they are for good.
    is_final : bool
        Whether the contour has all but arrived, so that goals may settle for good.
    """

    domain: Domain
    config: PartitionConfig
    free: BoolArray
    is_final: bool


def knots_for(duration_s: float) -> int:
    """Return how many knots the track of a motion of this duration has."""
    return min(max(KNOTS_MIN, math.ceil(duration_s / KNOT_S) + 1), KNOTS_MAX)


def track(  # noqa: PLR0913 - what moves, for whom, between what, how
    morph: Morph,
    goals: GoalSet,
    roster: Roster,
    obstacles: tuple[FloatArray, ...],
    config: PartitionConfig,
    *,
    knots: int,
) -> FloatArray:
    """Find where goals are while their shape moves.

    Parameters
    ----------
    morph : Morph
        Motion of the contour.
    goals : GoalSet
        Where they begin.
    roster : Roster
        For whom they are.
    obstacles : tuple of (m, 2) array
        Polygons that goals stay clear of [m].
    config : PartitionConfig
        Method, gaps and tuning.
    knots : int
        At how many equal intervals of time, both ends included, goals are wanted; at least 2.

    Returns
    -------
    (knots, n, 2) array
        Whole centimeters [m]. At every knot but the first, which has the goals as they are given, circles are inside
        the contour and keep all gaps up to that rounding; half-way between knots no two of them overlap. Equal inputs
        give equal tracks.

    Raises
    ------
    ShapeError
        If the method cannot move goals, there is no room for the robots on the way, or knots are too far apart for
        what they do between them.
    """
    relax = None if config.extension is not None else RELAXATIONS.get(config.method)
    if relax is None:
        able = " or ".join(method.value for method in RELAXATIONS)
        raise ShapeError(f"partition method {config.name} is not applicable to moving shapes; use {able}")
    radii, gaps = roster.radii_of(goals.types), _rounded(config.gaps)
    shares = np.linspace(0.0, 1.0, STEPS * (knots - 1) + 1).tolist()
    domains = [_domain(morph, share, obstacles, radii, gaps) for share in shares]
    start = goals.positions.round(DECIMALS) + 0.0
    free = morph.distances_to_change(start) < REACH * domains[0].spacing
    settled, held = start, _Held(start, PLAY * domains[0].spacing)
    places = [start]
    for step, (before, share) in enumerate(pairwise(shares), start=1):
        # Goals that settle for a contour to come are not behind when it is there.
        later = min(step + AHEAD, len(shares) - 1)
        ahead, is_final = domains[later], step > len(shares) - STEPS
        # The contour's turn until then is no change to settle for: it would push goals along.
        seen = shares[later] if morph.rotation_rad else share
        begun = morph.carried(settled, before, seen)
        settled = relax(Relaxing(ahead, config, free, is_final), begun)
        settled = np.where(_leaves(ahead.contour, begun, settled)[:, None], begun, settled)
        settled = morph.carried(settled, seen, share) if morph.rotation_rad else settled
        parted = held.follow(settled, morph.carried(held.places, before, share), domains[step])
        settled = np.where(parted[:, None], held.places, settled)
        places.append(held.places)
    smooth = _smoothed(morph, np.stack(places[::STEPS]))
    for knot, domain in enumerate(domains[STEPS::STEPS], start=1):
        separator = Separator(domain)
        smooth[knot] = separator.apart(smooth[knot], FINAL_SWEEPS)
        if not separator.is_separated(smooth[knot]):
            raise ShapeError(_no_room(knot / (knots - 1)))
    found: FloatArray = smooth.round(DECIMALS) + 0.0  # no negative zeros
    _check_between(found, morph, radii)
    return found


def _check_between(places: FloatArray, morph: Morph, radii: FloatArray) -> None:
    """Refuse a track on which circles overlap half-way between two knots: there, ways are farthest from them.

    Raises
    ------
    ShapeError
        Saying after which share of the time.
    """
    ways, intervals = Ways(places, morph.centers, morph.rotation_rad), len(places) - 1
    least = np.triu(radii[:, None] + radii, 1)  # of each pair once
    for share in ((np.arange(intervals) + 0.5) / intervals).tolist():
        x, y = ways.goals(share).T
        if (np.hypot(x[:, None] - x, y[:, None] - y) < least).any():
            raise ShapeError(
                f"after {100.0 * share:.0f} % of its motion goals of the shape come too near to each other;"
                " give it more time, or go by way of a shape in between"
            )


class _Held:
    """Goals that stay where they are until they are to be elsewhere by more than their play, and then come along.

    Parameters
    ----------
    places : (n, 2) array
        [m].
    play : float
        [m].
    """

    def __init__(self, places: FloatArray, play: float) -> None:
        self.places = places
        self._play = np.full(len(places), play)

    def follow(self, settled: FloatArray, carried: FloatArray, domain: Domain) -> BoolArray:
        """Move toward where goals would settle, from where the common motion carries them; nearly all gaps are kept.

        Returns
        -------
        (n,) bool array
            Goals that cannot get there inside the contour: where the shape parts, they stay with their side.
        """
        ahead = settled - carried
        distances = np.sqrt((ahead * ahead).sum(axis=1))
        drawn = carried + ahead * (1.0 - np.minimum(1.0, self._play / np.maximum(distances, self._play)))[:, None]
        parted = _leaves(domain.contour, carried, drawn)
        self._play = np.where(distances > self._play, PLAY_LEFT * self._play, self._play)
        self.places = Separator(domain).apart(np.where(parted[:, None], carried, drawn), SWEEPS)
        return parted


def _leaves(contour: FloatArray, starts: FloatArray, ends: FloatArray) -> BoolArray:
    """Return whether the straight way from each of (n, 2) points inside a contour to its end leaves it, (n,)."""
    shape = Polygon(contour)
    shapely.prepare(shape)
    begins_inside = shapely.contains_xy(shape, starts[:, 0], starts[:, 1])
    stays = shapely.covers(shape, shapely.linestrings(np.stack([starts, ends], axis=1)))
    leaves: BoolArray = begins_inside & ~stays
    return leaves


def _domain(morph: Morph, share: float, obstacles: tuple[FloatArray, ...], radii: FloatArray, gaps: Gaps) -> Domain:
    """Return where goals may be after a share of the time.

    Raises
    ------
    ShapeError
        If that is nowhere.
    """
    domain = Domain(morph.at(share), obstacles, radii, gaps)
    if any(region.is_empty for region in domain.regions):
        raise ShapeError(_no_room(share))
    return domain


def _smoothed(morph: Morph, places: FloatArray) -> FloatArray:
    """Return (knots, n, 2) goals on smoother ways with the same ends; a goal at rest stays exactly where it is."""
    shares = np.linspace(0.0, 1.0, len(places))
    for _ in range(SMOOTHINGS):
        smooth = places.copy()
        for knot in range(1, len(places) - 1):
            here, share = places[knot], shares[knot]
            before = morph.carried(places[knot - 1], shares[knot - 1], share)
            after = morph.carried(places[knot + 1], shares[knot + 1], share)
            smooth[knot] = here + 0.25 * ((before - here) + (after - here))
        places = smooth
    return places


def _bubbles(step: Relaxing, centers: FloatArray) -> FloatArray:
    return Packing(step.config.bubbles, step.domain).relaxed(centers, ITERATIONS, step.free)


def _descent(step: Relaxing, centers: FloatArray) -> FloatArray:
    """Return the centers after some steps toward a centroidal Voronoi tessellation, near the origin (`Region`).

    As in the partition of a shape at rest, the packing of bubbles helps where the tessellation would get stuck: in a
    shape that becomes longer and narrower, rows of cells have to join.
    """
    domain, tuning, origin = step.domain, step.config.voronoi, step.domain.center
    shape = Polygon(domain.contour - origin)
    shape = shape.difference(shapely.union_all([Polygon(outline - origin) for outline in domain.obstacles])).buffer(0.0)
    weights = tuning.radius_share * domain.spacing * domain.radii
    flows = bool(step.free.all()) and not step.is_final
    if flows:
        centers = Packing(step.config.bubbles, domain).relaxed(centers, PUSHES)
    gain = tuning.triangle_gain * (SOFTNESS if flows else 1.0)
    energy = MeshEnergy(Region(shape), shape.area, weights, gain)

    def of_the_free(sites: FloatArray) -> tuple[float, FloatArray]:
        value, slope = energy(sites)
        return value, np.where(step.free[:, None], slope, 0.0)

    step_max, tolerance = STEP_MAX * domain.spacing, tuning.tolerance_m
    return origin + minimize(of_the_free, centers - origin, step_max=step_max, tolerance=tolerance, steps_max=DESCENTS)


RELAXATIONS: Mapping[Method, Callable[[Relaxing, FloatArray], FloatArray]] = {
    Method.BUBBLE_PACKING: _bubbles,
    Method.VORONOI: _descent,
}
"""Laws by which goals settle while their shape moves; what is not here draws its goals anew each time."""


def _rounded(gaps: Gaps) -> Gaps:
    """Return the gaps that are left when goals that keep them are rounded, so that goals at rest keep these as well."""
    return replace(
        gaps,
        robot_m=max(gaps.robot_m - 2.0 * ROUNDING_M, GAP_MIN_M),
        contour_m=max(gaps.contour_m - ROUNDING_M, GAP_MIN_M),
        obstacle_m=max(gaps.obstacle_m - ROUNDING_M, GAP_MIN_M),
    )


def _no_room(share: float) -> str:
    return (
        f"after {100.0 * share:.0f} % of its motion the shape has no room for the robots; go by way of a wider shape,"
        " or choose a larger one"
    )
