"""Bubble packing: circles that push each other apart and away from the contour until they rest (thesis 3.2.2.1)."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from swarm_msgs_py.geometry.contour_integrals import ShapeForce
from swarm_msgs_py.partition.config import BubbleConfig, BubbleLaw
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.initial_placement import place
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.types import FloatArray

THESIS_RANGE = 2.5  # [m], l0 of thesis eq. (3.95)
DISTANCE_MIN = 1e-9  # [m]; two bubbles in one place push each other nowhere, and the separator parts them
THESIS_PEAK = 4.0  # force of (3.95) at zero distance; brings its steps to the size of the scaled law's
STEP_FLOOR = 0.2  # share of the step limit that is left in the last iteration
SWEEPS = 2  # of pushing apart, per iteration; the next iteration goes on where they end


class BubblePacking:
    """The partition method of the thesis' section 3.2.2.1, with a force law scaled to the area per robot.

    Parameters
    ----------
    config : BubbleConfig
        Law and tuning.
    """

    def __init__(self, config: BubbleConfig) -> None:
        self._config = config

    def fits(self, domain: Domain) -> bool:
        """Return whether Algorithm 1 finds room for every circle; the packing only improves on it."""
        return place(domain) is not None

    def place(self, domain: Domain) -> FloatArray | None:
        """Return the (n, 2) centers of the packed circles, which keep all gaps; None if Algorithm 1 finds no room."""
        placed = place(domain)
        return None if placed is None else self._relax(domain, placed)

    def _relax(self, domain: Domain, placed: FloatArray) -> FloatArray:
        """Return the centers at rest; they keep all gaps if those of `placed` do."""
        config = self._config
        law = _LAWS[config.law](config, domain)
        shape_force = ShapeForce(domain.contour)
        separator = Separator(domain)
        centers = placed
        for iteration in range(config.iterations_max):
            done = iteration / config.iterations_max
            stretch = 1.0
            if config.softening:
                stretch += config.softness * max(0.0, 1.0 - done / config.softening)
            force = law.between(centers, stretch) + law.shape_gain * shape_force.at(centers)
            limit = config.step_max * law.base * (STEP_FLOOR + (1.0 - STEP_FLOOR) * (1.0 - done))
            steps = law.mobility * force
            lengths = np.sqrt(np.einsum("nd,nd->n", steps, steps))
            steps *= np.minimum(1.0, limit / np.maximum(lengths, limit))[:, None]
            moved = separator.apart(centers + steps, SWEEPS)
            longest = float(np.abs(moved - centers).max())
            centers = moved
            if longest < config.tolerance_m and stretch == 1.0:
                break
        centers = separator.apart(centers, FINAL_SWEEPS)
        return centers if separator.is_separated(centers) else placed


class _Law(ABC):
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
    def magnitude(self, distances: FloatArray, stretch: float) -> FloatArray:
        """Return the (n, n) force between centers at these distances, the range `stretch` times as long."""

    def between(self, centers: FloatArray, stretch: float) -> FloatArray:
        """Return the (n, 2) force of all other bubbles on each of (n, 2) centers."""
        x, y = centers.T
        dx, dy = x[:, None] - x, y[:, None] - y
        distances = np.sqrt(dx * dx + dy * dy)
        np.fill_diagonal(distances, np.inf)
        push = self.magnitude(distances, stretch) / np.maximum(distances, DISTANCE_MIN)
        return np.column_stack([np.einsum("ij,ij->i", push, dx), np.einsum("ij,ij->i", push, dy)])


class _ScaledLaw(_Law):
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

    def magnitude(self, distances: FloatArray, stretch: float) -> FloatArray:
        x = np.minimum(distances / (stretch * self._ranges), 1.0)
        force: FloatArray = (1.25 * x - 2.375) * x * x + 1.125
        return force


class _ThesisLaw(_Law):
    """Force of thesis eq. (3.95), which jumps to zero at its fixed range and knows no radii."""

    def __init__(self, config: BubbleConfig, domain: Domain) -> None:  # noqa: ARG002 - the signature of all laws
        self.base = THESIS_RANGE
        self.shape_gain = 1.0
        self.mobility = config.step * THESIS_RANGE / THESIS_PEAK

    def magnitude(self, distances: FloatArray, stretch: float) -> FloatArray:  # noqa: ARG002
        x = np.minimum(distances, THESIS_RANGE)
        force: FloatArray = np.where(distances <= THESIS_RANGE, ((-0.1 * x - 0.2) * x - 0.3) * x + THESIS_PEAK, 0.0)
        return force


_LAWS: dict[BubbleLaw, type[_ScaledLaw] | type[_ThesisLaw]] = {
    BubbleLaw.SCALED: _ScaledLaw,
    BubbleLaw.THESIS: _ThesisLaw,
}
