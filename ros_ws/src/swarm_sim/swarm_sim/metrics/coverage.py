"""How well placed robots cover a solid, and whether they stay linked (spec section 11 of the coverage family)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from swarm_msgs_py.geometry.solids.sampling import interior_points, surface_points
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class CoverageQuality:
    """Share of a shape that is covered.

    Attributes
    ----------
    covered_fraction, covered_error : float
        Share of the volume, and its standard error.
    boundary_fraction : float
        Share of the surface.
    worst_gap_m : float
        How far the least covered point is beyond the range of its nearest robot [m]; 0 if all are covered.
    """

    covered_fraction: float
    covered_error: float
    boundary_fraction: float
    worst_gap_m: float


class CoverageProbe:
    """Measures coverage by the same random points each time.

    Parameters
    ----------
    solid : Solid
    radius : float
        r_sc [m].
    seed : int
        Of the points, so that methods are compared on the same ones.
    inner, outer : int
        Points inside the shape and on its surface; 1e5 inside tell 0.9995 to 7e-5.

    Attributes
    ----------
    surface : (k, 3) array
        The points on the surface [m].

    Raises
    ------
    ShapeError
        If the shape is empty.
    """

    def __init__(self, solid: Solid, radius: float, seed: int, inner: int = 100_000, outer: int = 20_000) -> None:
        self._radius = radius
        self._inner = interior_points(solid, inner, rng_for(seed, "coverage", "probe"))
        self.surface = surface_points(solid, outer, rng_for(seed, "coverage", "boundary"))

    def measure(self, positions: FloatArray) -> CoverageQuality:
        """Return how well robots at `positions` (n, 3) [m], all with their sensors on, cover the shape; n >= 1."""
        tree = cKDTree(positions)
        inner, outer = tree.query(self._inner)[0], tree.query(self.surface)[0]
        share = float((inner <= self._radius).mean())
        return CoverageQuality(
            covered_fraction=share,
            covered_error=float(np.sqrt(share * (1.0 - share) / len(inner))),
            boundary_fraction=float((outer <= self._radius).mean()),
            worst_gap_m=max(0.0, float(max(inner.max(), outer.max())) - self._radius),
        )


def component_count(size: int, links: IntArray) -> int:
    """Return how many pieces `links`, pairs of rows (l, 2), make of `size` nodes."""
    graph = csr_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(size, size))
    return int(connected_components(graph, directed=False, return_labels=False))


def close_pairs(positions: FloatArray, radius: float) -> IntArray:
    """Return the pairs of rows of `positions` (n, 3) [m] that are strictly closer than `radius` [m], (l, 2)."""
    pairs: IntArray = cKDTree(positions).query_pairs(radius, output_type="ndarray")
    spans = positions[pairs[:, 0]] - positions[pairs[:, 1]]
    close: IntArray = pairs[np.einsum("ij,ij->i", spans, spans) < radius * radius]
    return close


def live_components(alive: BoolArray, links: IntArray) -> int:
    """Return into how many pieces links (l, 2) between rows leave the robots that live, (n,)."""
    return component_count(len(alive), links) - int(np.count_nonzero(~alive))
