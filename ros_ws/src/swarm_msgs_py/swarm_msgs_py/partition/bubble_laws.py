"""How hard bubbles push each other, by their distance."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from swarm_msgs_py.partition.config import BubbleConfig, BubbleLaw
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.types import FloatArray

THESIS_RANGE = 2.5  # [m], l0 of thesis eq. (3.95)
DISTANCE_MIN = 1e-9  # [m]; two bubbles in one place push each other nowhere, and the separator parts them
THESIS_PEAK = 4.0  # force of (3.95) at zero distance; brings its steps to the size of the scaled law's


class BubbleLawForce(ABC):
    """Force between bubbles, with the scales that belong to it.

    Attributes
    ----------
    base : float
        Range l0 for a pair of mean radius [m].
    shape_gain : float
        Factor of the shape force.
    mobility : float
        Step per unit of force [m].
    """

    base: float
    shape_gain: float
    mobility: float

    @abstractmethod
    def magnitude(self, distances: FloatArray, stretch: float | FloatArray) -> FloatArray:
        """Return the (n, n) force between centers at these distances, with ranges `stretch` times as long."""

    def between(self, centers: FloatArray, stretch: float | FloatArray) -> FloatArray:
        """Return the (n, 2) force of all other bubbles on each of (n, 2) centers."""
        dx, dy, distances = _offsets(centers)
        push = self.magnitude(distances, stretch) / np.maximum(distances, DISTANCE_MIN)
        return np.column_stack([(push * dx).sum(axis=1), (push * dy).sum(axis=1)])

    def pressures(self, centers: FloatArray) -> FloatArray:
        """Return the sum of the magnitudes of all forces on each of (n, 2) centers, (n,)."""
        pressures: FloatArray = self.magnitude(_offsets(centers)[2], 1.0).sum(axis=1)
        return pressures


def _offsets(centers: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the offsets along x and y from each other center, and the distances, infinite to oneself; (n, n) each."""
    x, y = centers.T
    dx, dy = x[:, None] - x, y[:, None] - y
    distances = np.sqrt(dx * dx + dy * dy)
    np.fill_diagonal(distances, np.inf)
    return dx, dy, distances


class _ScaledLaw(BubbleLawForce):
    """Repulsive part of the bubble-mesh force, ending smoothly at a range that follows the area per robot.

    References
    ----------
    .. [1] K. Shimada, D. C. Gossard, "Bubble mesh", ACM Symposium on Solid Modeling, 1995.
    """

    def __init__(self, config: BubbleConfig, domain: Domain) -> None:
        self.base = config.beta * domain.spacing
        self.shape_gain = config.kappa * self.base / 4.0
        self.mobility = config.step * self.base
        sums = domain.radii[:, None] + domain.radii
        share = sums / (2.0 * float(domain.radii.mean())) - 1.0
        # A large pair in a tight shape must begin to push before it touches.
        self._ranges = np.maximum(self.base * (1.0 + config.eta * share), domain.least_distances)

    def magnitude(self, distances: FloatArray, stretch: float | FloatArray) -> FloatArray:
        x = np.minimum(distances / (stretch * self._ranges), 1.0)
        force: FloatArray = (1.25 * x - 2.375) * x * x + 1.125
        return force


class _ThesisLaw(BubbleLawForce):
    """Force of thesis eq. (3.95), which jumps to zero at its fixed range and knows no radii."""

    def __init__(self, config: BubbleConfig, domain: Domain) -> None:  # noqa: ARG002 - the signature of all laws
        self.base = THESIS_RANGE
        self.shape_gain = 1.0
        self.mobility = config.step * THESIS_RANGE / THESIS_PEAK

    def magnitude(self, distances: FloatArray, stretch: float | FloatArray) -> FloatArray:  # noqa: ARG002
        x = np.minimum(distances, THESIS_RANGE)
        force: FloatArray = np.where(distances <= THESIS_RANGE, ((-0.1 * x - 0.2) * x - 0.3) * x + THESIS_PEAK, 0.0)
        return force


LAWS: dict[BubbleLaw, type[_ScaledLaw] | type[_ThesisLaw]] = {
    BubbleLaw.SCALED: _ScaledLaw,
    BubbleLaw.THESIS: _ThesisLaw,
}
"""How to make each law from the tuning and the problem."""
