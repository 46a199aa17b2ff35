"""From a shape to goals: one circle per robot, or an error that says how large the shape would have to be."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.partition.config import CircleSizes, Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain, check_obstacles
from swarm_msgs_py.partition.method import PartitionMethod, method_for
from swarm_msgs_py.partition.parts import parts_of, shared_out
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, IntArray

SCALE_STEP = 1.02  # how finely the remedy of a too small shape is searched
SCALE_MAX = 1e6  # a shape that is too small even at this scale has no remedy by scaling


@dataclass(frozen=True, slots=True, eq=False)
class GoalSet:
    """Where robots are to be.

    Attributes
    ----------
    positions : (n, 2) array
        Centers [m]; the row number is the goal's id.
    types : (n,) int array
        Type of robot that each goal has room for.
    """

    positions: FloatArray
    types: IntArray


def partition(
    shape: FloatArray,
    roster: Roster,
    obstacles: tuple[FloatArray, ...] = (),
    config: PartitionConfig | None = None,
    *,
    keep_outs: tuple[FloatArray, ...] = (),
) -> GoalSet:
    """Fill a shape with one goal per robot.

    Parameters
    ----------
    shape : (k, 2) array
        Simple counter-clockwise contour, as `load_shape` returns it [m].
    roster : Roster
        Whom to place.
    obstacles : tuple of (m, 2) array
        Polygons of the map: goals stay clear of them, and the shape must not lie over them [m].
    config : PartitionConfig or None
        Method and tuning; None for the defaults.
    keep_outs : tuple of (m, 2) array
        Polygons that goals stay clear of, wherever they are, e.g. around what stands in the shape [m].

    Returns
    -------
    GoalSet
        As many goals of each type as the roster has robots. Every robot's circle is inside the contour, and keeps the
        gaps of the configuration. Equal inputs give equal goals in equal order.

    Raises
    ------
    ShapeError
        If the shape lies over an obstacle (which, where), or is too small for the robots (with the scale it needs).
    """
    check_obstacles(shape, obstacles)
    polygons = _Polygons((shape, *obstacles, *keep_outs))
    return _partition(polygons, roster, config or PartitionConfig())


class _Polygons:
    """Polygons that compare by content, as a key under which what follows from them can be kept."""

    def __init__(self, polygons: tuple[FloatArray, ...]) -> None:
        self.arrays = tuple(np.array(polygon, dtype=np.float64) for polygon in polygons)
        self._content = tuple(polygon.tobytes() for polygon in self.arrays)

    def __hash__(self) -> int:
        return hash(self._content)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Polygons) and self._content == other._content


@lru_cache(maxsize=64)  # checks and first plans are of one shape; batches take methods and shapes in turn
def _partition(polygons: _Polygons, roster: Roster, config: PartitionConfig) -> GoalSet:
    shape, *obstacles = polygons.arrays
    method = method_for(config)
    parts = parts_of(shape)
    goals = _in_parts(parts, roster, tuple(obstacles), config, method) if len(parts) > 1 else None
    if goals is None:
        domain, types = _posed(shape, roster.interleaved_types(), roster, tuple(obstacles), config, method)
        centers = method.place(domain)
        if centers is None:
            raise ShapeError(_hurwitz_remedy(domain, config) or _remedy(domain, types, roster, method))
        goals = GoalSet(centers, types)
    goals.positions.flags.writeable = goals.types.flags.writeable = False
    return goals


def _in_parts(
    parts: tuple[FloatArray, ...],
    roster: Roster,
    obstacles: tuple[FloatArray, ...],
    config: PartitionConfig,
    method: PartitionMethod,
) -> GoalSet | None:
    """Return goals of which every part of a shape has as many as its area asks for; None if they do not fit so."""
    types, room = roster.interleaved_types(), np.full(len(parts), roster.size)
    while (shares := shared_out(parts, types, room)) is not None:
        posed = [
            _posed(part, members, roster, obstacles, config, method)
            for part, members in zip(parts, shares, strict=True)
            if len(members)
        ]
        filled = [part for part, members in enumerate(shares) if len(members)]
        shortages = {part: method.shortage(domain) for part, (domain, _) in zip(filled, posed, strict=True)}
        short = {part: shortage.placed for part, shortage in shortages.items() if shortage is not None}
        if not short:
            return _united(posed, method, roster)
        for part, placed in short.items():  # the others take what has no room there
            room[part] = placed
    return None


def _united(posed: list[tuple[Domain, IntArray]], method: PartitionMethod, roster: Roster) -> GoalSet | None:
    """Return the goals of all parts; None if some are too near to each other across the gap between two parts."""
    placed = [(method.place(domain), types) for domain, types in posed]
    centers = np.concatenate([places for places, _ in placed if places is not None])
    types = np.concatenate([types for places, types in placed if places is not None])
    if len(centers) < roster.size:
        return None
    distances = np.linalg.norm(centers[:, None] - centers, axis=2)
    gaps = posed[0][0].gaps
    least = Domain(posed[0][0].contour, (), roster.radii_of(types), gaps).least_distances
    return GoalSet(centers, types) if (distances >= least * (1.0 - 1e-9)).all() else None


def forget() -> None:
    """Forget all partitions, so that this process finds its goals itself and does not go by those of its parent."""
    _partition.cache_clear()


def adapt(
    goals: GoalSet,
    shape: FloatArray,
    roster: Roster,
    obstacles: tuple[FloatArray, ...] = (),
    config: PartitionConfig | None = None,
) -> GoalSet | None:
    """Move given goals no farther than the shape and the obstacles make necessary; most stay exactly where they are.

    Parameters
    ----------
    goals : GoalSet
        Goals of an earlier shape, or of the same one with fewer obstacles.
    shape, roster, config
        As for `partition`.
    obstacles : tuple of (m, 2) array
        Polygons that goals stay clear of, wherever they are [m].

    Returns
    -------
    GoalSet or None
        Goals of the same types in the same order that keep all gaps; None if pushing does not get them apart, and the
        shape is to be partitioned anew.
    """
    config = config or PartitionConfig()
    domain = Domain(shape, obstacles, roster.radii_of(goals.types), config.gaps)
    if any(region.is_empty for region in domain.regions):
        return None
    separator = Separator(domain)
    centers = separator.apart(goals.positions, FINAL_SWEEPS)
    return GoalSet(centers, goals.types) if separator.is_separated(centers) else None


def check_fits(
    shape: FloatArray,
    roster: Roster,
    obstacles: tuple[FloatArray, ...] = (),
    config: PartitionConfig | None = None,
) -> None:
    """Refuse what `partition` would refuse, in a fraction of its time.

    Raises
    ------
    ShapeError
        As `partition`.
    """
    config = config or PartitionConfig()
    method = method_for(config)
    check_obstacles(shape, obstacles)
    domain, types = _posed(shape, roster.interleaved_types(), roster, obstacles, config, method)
    if method.shortage(domain) is not None:
        raise ShapeError(_hurwitz_remedy(domain, config) or _remedy(domain, types, roster, method))


def needed_scale(shape: FloatArray, roster: Roster, config: PartitionConfig | None = None) -> float | None:
    """Return the factor by which a shape has to be scaled for the robots to fit; 1 if they do, None if none helps.

    Parameters
    ----------
    shape, roster, config
        As for `partition`; obstacles do not count.
    """
    config = config or PartitionConfig()
    method = method_for(config)
    domain, _ = _posed(shape, roster.interleaved_types(), roster, (), config, method)
    return 1.0 if method.shortage(domain) is None else _needed_scale(domain, method)


def _posed(  # noqa: PLR0913, PLR0917 - the problem, with who it is for
    shape: FloatArray,
    types: IntArray,
    roster: Roster,
    obstacles: tuple[FloatArray, ...],
    config: PartitionConfig,
    method: PartitionMethod,
) -> tuple[Domain, IntArray]:
    """Return the problem with its circles in the better order, and the type of each circle.

    Types take turns, so that each type is spread over the whole shape; where that leaves no room, large ones go first.
    """
    domain = Domain(shape, obstacles, roster.radii_of(types), config.gaps)
    if method.shortage(domain) is None:
        return domain, types
    order = np.argsort(-domain.radii, kind="stable")
    return domain.reordered(order), types[order]


def _remedy(domain: Domain, types: IntArray, roster: Roster, method: PartitionMethod) -> str:
    """Return the line for the operator when circles, largest first, do not fit."""
    bare = Domain(domain.contour, (), domain.radii, domain.gaps)
    shortage = method.shortage(bare)
    if shortage is None:
        return (
            "obstacles in or beside the shape leave too little room for the robots; move the shape away or scale it up"
        )
    tight = [
        f"type {group.type} (radius {group.coverage_radius_m:g} m)"
        for group in roster.groups
        if bare.regions[bare.classes.index(group.coverage_radius_m)].is_empty
    ]
    problem = f"too narrow for robots of {' and '.join(tight)}" if tight else f"too small for {roster.size} robots"
    scale = _needed_scale(bare, method)
    if scale is None:
        return f"a shape of {domain.area:.3g} m2 is {problem}, at any scale; choose a less jagged one"
    needed = domain.area * scale**2
    return (
        f"a shape of {domain.area:.3g} m2 is {problem}: needs {needed:.3g} m2; scale it by at least {scale:g}"
        f" (circle {shortage.placed + 1} of {roster.size}, for type {types[shortage.circle]} of radius"
        f" {domain.radii[shortage.circle]:g} m, found no room; {shortage.free_area:.3g} m2 are free)"
    )


def _hurwitz_remedy(domain: Domain, config: PartitionConfig) -> str | None:
    """Return the line for the operator when only the Hurwitz rule leaves no room; None if it is not to blame.

    Its circles grow with the shape, so to scale the shape is no remedy.
    """
    fractals = config.fractals
    is_fractal = config.extension is None and config.method is Method.FRACTALS
    if not is_fractal or fractals.sizes is not CircleSizes.HURWITZ:
        return None
    short = method_for(config).shortage(domain)
    of_robots = replace(config, fractals=replace(fractals, sizes=CircleSizes.COVERAGE))
    if short is None or method_for(of_robots).shortage(domain) is not None:
        return None
    return (
        f"circle {short.placed + 1} of {len(domain.radii)} found no room: the circles of the Hurwitz rule (exponent"
        f" {fractals.exponent:g}, shift {fractals.shift:g}) grow with the shape, so scaling it does not help; lower"
        " partition.fractals.exponent, raise partition.fractals.shift, take another seed, or set"
        f" partition.fractals.sizes to {CircleSizes.COVERAGE.value}"
    )


def _needed_scale(domain: Domain, method: PartitionMethod) -> float | None:
    """Return a factor, rounded up to two decimals, by which the contour is just large enough; None if there is none."""
    circles = float(np.pi * (domain.radii**2).sum())
    low, high = 1.0, max(1.0, math.sqrt(circles / domain.area))
    while method.shortage(domain.scaled(high)) is not None:
        low, high = high, 1.3 * high
        if high > SCALE_MAX:
            return None
    while high > SCALE_STEP * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if method.shortage(domain.scaled(middle)) else (low, middle)
    # The first placement is greedy, so more room is not always better: what is promised has been tried.
    scale = math.ceil(100.0 * high) / 100.0
    while method.shortage(domain.scaled(scale)) is not None:
        scale = math.ceil(100.0 * SCALE_STEP * scale) / 100.0
    return scale
