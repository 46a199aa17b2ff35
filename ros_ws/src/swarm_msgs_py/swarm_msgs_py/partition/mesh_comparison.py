"""Whether one mesh is as good as another in every metric, which no weighted sum of metrics can tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.geometry.mesh_quality import mesh_quality_in
from swarm_msgs_py.types import FloatArray

FLOOR = 1e-3  # added to both values of a ratio, as the reference may be perfect
MARGIN = 0.005  # of a metric that changes with every move: about what the rounding of goals to a centimeter takes
PERFECT = 1e-9  # below this a metric is 0 up to rounding
DECIMALS = 6  # so that last bits decide nothing between meshes that are equal by symmetry


@dataclass(frozen=True, slots=True, order=True)
class Standing:
    """How a mesh compares with the reference; the lesser, the better.

    Attributes
    ----------
    excess : float
        Sum of the metrics' ratios to the reference, as far as they are above 1; 0: not worse in any.
    total : float
        Sum of all ratios.
    is_worse_connected : bool
        Whether a topological irregularity is worse, which small moves do not mend.
    """

    excess: float
    total: float
    is_worse_connected: bool


class MeshComparison:
    """Compares meshes with a reference in every metric: irregularities, variations, and what is left uncovered.

    Parameters
    ----------
    shape : shapely polygon or multi-polygon
        What the meshes are to fill [m].
    radii : (n,) array
        Of the circles around the sites [m].
    reference : (n, 2) array
        Sites of the mesh to compare with [m].
    """

    def __init__(self, shape: BaseGeometry, radii: FloatArray, reference: FloatArray) -> None:
        self._shape = shape
        self._radii = radii
        self._reference = self._metrics(reference)

    def standing(self, sites: FloatArray, margin: float = MARGIN) -> Standing:
        """Return how a mesh compares.

        Parameters
        ----------
        sites : (n, 2) array
            [m].
        margin : float
            By this share a metric that changes with every move must be better than the reference; 0 for goals that will
            not move any more.
        """
        topological, geometrical = (
            np.round([_ratio(value, known) for value, known in zip(values, reference, strict=True)], DECIMALS)
            for values, reference in zip(self._metrics(sites), self._reference, strict=True)
        )
        excess = np.maximum(topological - 1.0, 0.0).sum() + np.maximum(geometrical - (1.0 - margin), 0.0).sum()
        total = topological.sum() + geometrical.sum()
        worse = bool((topological > 1.0).any())
        return Standing(round(float(excess), DECIMALS), round(float(total), DECIMALS), worse)

    def _metrics(self, sites: FloatArray) -> tuple[tuple[float | None, ...], tuple[float | None, ...]]:
        """Return the metrics that count neighbors, and those that change with every move; the less, the better."""
        quality = mesh_quality_in(self._shape, sites, self._radii)
        return (quality.topological_interior, quality.topological), (
            quality.geometrical,
            quality.geometrical_cells,
            quality.area_variation,
            quality.gap_variation,
            1.0 - quality.covered_fraction,
        )


def _ratio(value: float | None, reference: float | None) -> float:
    """Return the ratio of two values of a metric, 1 less the margin where one is not defined or both are perfect."""
    if value is None or reference is None or max(value, reference) < PERFECT:
        return 1.0 - MARGIN
    return (value + FLOOR) / (reference + FLOOR)
