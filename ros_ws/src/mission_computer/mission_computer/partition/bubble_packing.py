"""Bubble packing: circles that push each other apart and away from the contour until they rest (thesis 3.2.2.1)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mission_computer.partition.config import BubbleConfig, BubbleLaw
from mission_computer.partition.domain import Domain
from mission_computer.partition.initial_placement import place
from mission_computer.partition.separation import is_separated, separate
from mission_computer.partition.shape_force import ShapeForce
from swarm_msgs_py.types import FloatArray

THESIS_RANGE = 2.5  # [m], l0 of thesis eq. (3.95)
THESIS_PEAK = 4.0  # force of (3.95) at zero distance; brings its steps to the size of the scaled law's
STEP_FLOOR = 0.2  # share of the step limit that is left in the last iteration

PairForce = Callable[[FloatArray], FloatArray]


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

    def place(self, domain: Domain, start: FloatArray | None = None) -> FloatArray | None:
        """Return the centers of the packed circles.

        Parameters
        ----------
        domain : Domain
        start : (n, 2) array or None
            Where to start from, e.g. the goals of the shape before it changed; None: Algorithm 1.

        Returns
        -------
        (n, 2) array or None
            Centers that keep all gaps; None if Algorithm 1 finds no room.
        """
        centers = place(domain) if start is None else separate(domain, start)
        return None if centers is None else self._relax(domain, centers)

    def _relax(self, domain: Domain, centers: FloatArray) -> FloatArray:
        """Return the centers at rest; they keep all gaps if the given ones do."""
        config = self._config
        scaled = config.law is BubbleLaw.SCALED
        base = config.beta * domain.spacing if scaled else THESIS_RANGE
        pair_force = self._pair_force(domain, base)
        shape_force = ShapeForce(domain.contour)
        shape_gain = config.kappa * base / 4.0 if scaled else 1.0
        gain = config.step * base / (1.0 if scaled else THESIS_PEAK)
        feasible = centers
        for iteration in range(config.iterations_max):
            force = pair_force(centers) + shape_gain * shape_force.at(centers)
            left = 1.0 - iteration / config.iterations_max
            limit = config.step_max * base * (STEP_FLOOR + (1.0 - STEP_FLOOR) * left)
            steps = gain * force
            lengths = np.sqrt(np.einsum("nd,nd->n", steps, steps))
            steps *= np.minimum(1.0, limit / np.maximum(lengths, limit))[:, None]
            moved = separate(domain, centers + steps)
            change = float(np.abs(moved - centers).max())
            centers = moved
            if change < config.tolerance_m:
                break
        return centers if is_separated(domain, centers) else feasible

    def _pair_force(self, domain: Domain, base: float) -> PairForce:
        """Return the function from (n, 2) centers to the (n, 2) force of all other bubbles on each."""
        mean = float(domain.radii.mean())
        share = (domain.radii[:, None] + domain.radii) / (2.0 * mean) - 1.0
        ranges = base * (1.0 + self._config.eta * share)
        # A large pair in a tight shape must begin to push before it touches.
        ranges = np.maximum(ranges, domain.least_distances)
        law = _scaled_law if self._config.law is BubbleLaw.SCALED else _thesis_law

        def force(centers: FloatArray) -> FloatArray:
            x, y = centers.T
            dx, dy = x[:, None] - x, y[:, None] - y
            distances = np.sqrt(dx * dx + dy * dy)
            np.fill_diagonal(distances, np.inf)
            pull = law(distances, ranges) / distances
            return np.column_stack([np.einsum("ij,ij->i", pull, dx), np.einsum("ij,ij->i", pull, dy)])

        return force


def _scaled_law(distances: FloatArray, ranges: FloatArray) -> FloatArray:
    """Return the repulsive part of the bubble-mesh force, which ends smoothly at the range.

    References
    ----------
    .. [1] K. Shimada, D. C. Gossard, "Bubble mesh", ACM Symposium on Solid Modeling, 1995.
    """
    x = np.minimum(distances / ranges, 1.0)
    force: FloatArray = (1.25 * x - 2.375) * x * x + 1.125
    return np.maximum(force, 0.0)


def _thesis_law(distances: FloatArray, _ranges: FloatArray) -> FloatArray:
    """Return the force of thesis eq. (3.95), which jumps to zero at its range."""
    x = np.minimum(distances, THESIS_RANGE)
    force: FloatArray = ((-0.1 * x - 0.2) * x - 0.3) * x + 4.0
    return np.where(distances <= THESIS_RANGE, force, 0.0)
