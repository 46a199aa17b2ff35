"""Bubble packing: circles that push each other apart and away from the contour until they rest (thesis 3.2.2.1)."""

from __future__ import annotations

import numpy as np
from shapely import Polygon

from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals
from swarm_msgs_py.partition.bubble_laws import LAWS
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.config import BubbleConfig
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.initial_placement import place, shortage
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.partition.rounding import on_grid
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.partition.spreading import spread_sizes
from swarm_msgs_py.types import BoolArray, FloatArray

STEP_FLOOR = 0.2  # share of the step limit that is left when bubbles come to rest
SWEEPS = 2  # of pushing apart, per iteration; the next iteration goes on where they end
ALL_WEIGHT = 1.5  # in the choice among meshes: bubbles tend to crowd along the contour
RIM_WIDTH = 0.7  # in spacings: holds the first row of bubbles and not the second
RIM_SLOPE = 3.0  # the rim fades out over the inner third of its width
HEALING_SOFTNESS = 0.2  # how much longer ranges are at first when one bubble has changed its place


class BubblePacking:
    """The partition method of the thesis' section 3.2.2.1, with a force law scaled to the area per robot.

    What comes to rest depends on the start, so a few placements by Algorithm 1, with other circles in the middle, are
    annealed, and the most regular mesh goes on. Then bubbles from where it is most crowded are tried in the largest
    hole, as the bubble meshes of the literature remove and insert bubbles; such a move stays if the mesh gains by it.

    All is computed in a frame that turns with the shape, so that no orientation is better than another.

    Parameters
    ----------
    config : BubbleConfig
        Law and tuning.

    References
    ----------
    .. [1] K. Shimada, D. C. Gossard, "Bubble mesh", ACM Symposium on Solid Modeling, 1995.
    """

    def __init__(self, config: BubbleConfig) -> None:
        self._config = config

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the circle for which Algorithm 1 finds no room, None if it places all; the packing improves on it."""
        return shortage(domain.entering(OwnFrame(domain.contour)))

    def place(self, domain: Domain) -> FloatArray | None:
        """Return the (n, 2) centers of the packed circles, which keep all gaps; None if Algorithm 1 finds no room."""
        frame = OwnFrame(domain.contour)
        own = domain.entering(frame)
        placed = place(own)
        if placed is None:
            return None
        packing = Packing(self._config, own)
        annealed = [packing.anneal(placed, 0.0)]
        for first in range(1, min(self._config.starts, len(placed))):
            start = place(own, first)
            if start is not None:
                # Meshes differ most in how many bubbles lie along the contour; these have fewer.
                annealed.append(packing.anneal(start, self._config.rim_stretch))
        healed = packing.heal(min(annealed, key=packing.irregularity))
        packed = (packing.rest(centers) for centers in (spread_sizes(own, healed), healed))
        return frame.leave(next((centers for centers in packed if centers is not None), placed))


class Packing:
    """Bubbles in a shape, and how they move.

    Parameters
    ----------
    config : BubbleConfig
    domain : Domain
    """

    def __init__(self, config: BubbleConfig, domain: Domain) -> None:
        self._config = config
        self._law = LAWS[config.law](config, domain)
        self._contour = ContourIntegrals(domain.contour)
        self._separator = Separator(domain)
        self._rim_width = RIM_WIDTH * domain.spacing
        shape = Polygon(domain.contour)
        self._mesh = MeshEnergy(Region(shape), shape.area, np.zeros(len(domain.radii)), 0.0)

    def irregularity(self, centers: FloatArray) -> float:
        """Return how far the mesh between the bubbles is from a hexagonal lattice."""
        return self._mesh.irregularity(centers, ALL_WEIGHT)

    def anneal(self, centers: FloatArray, rim_stretch: float) -> FloatArray:
        """Return the centers after ranges have come down to l0, beside the contour to a share more."""
        return self._settle(centers, self._config.softness, self._config.annealing_iterations, rim_stretch)

    def heal(self, centers: FloatArray) -> FloatArray:
        """Return the centers after moves of single bubbles from crowded places into holes, as far as they help."""
        least, crowded = self.irregularity(centers), 0
        for _ in range(self._config.healings):
            bubble = int(np.argsort(-self._pressures(centers), kind="stable")[crowded % len(centers)])
            hole = self._mesh.largest_hole(centers, bubble)
            if hole is None:
                break
            moved = centers.copy()
            moved[bubble] = hole
            moved = self._settle(moved, HEALING_SOFTNESS, self._config.healing_iterations)
            irregularity = self.irregularity(moved)
            crowded += 1
            if irregularity < least:
                centers, least, crowded = moved, irregularity, 0
        return centers

    def rest(self, centers: FloatArray) -> FloatArray | None:
        """Return the centers when no bubble moves any more; None if they do not keep all gaps then."""
        centers = self._separator.apart(self.relaxed(centers, self._config.iterations_max), FINAL_SWEEPS)
        return centers if self._separator.is_separated(centers) else None

    def relaxed(self, centers: FloatArray, iterations: int, free: BoolArray | None = None) -> FloatArray:
        """Return the centers after so many iterations, or when no bubble moves any more; of those that are free."""
        for _ in range(iterations):
            moved = self._step(centers, 1.0, STEP_FLOOR)
            if free is not None:
                moved = np.where(free[:, None], moved, centers)
            longest = float(np.abs(moved - centers).max())
            centers = moved
            if longest < self._config.tolerance_m:
                break
        return centers

    def _settle(self, centers: FloatArray, softness: float, iterations: int, rim_stretch: float = 0.0) -> FloatArray:
        """Return the centers after ranges began longer by `softness` and steps at their longest."""
        for iteration in range(iterations):
            left = 1.0 - iteration / iterations
            stretch: float | FloatArray = 1.0 + softness * max(0.0, 1.0 - (1.0 - left) / self._config.softening)
            if rim_stretch:
                stretch = stretch * self._rim_factors(centers, rim_stretch)
            centers = self._step(centers, stretch, STEP_FLOOR + (1.0 - STEP_FLOOR) * left)
        return centers

    def _rim_factors(self, centers: FloatArray, rim_stretch: float) -> FloatArray:
        """Return how much longer the range of each pair is for being beside the contour, (n, n)."""
        depths = self._contour.at(centers).signed_distances / self._rim_width
        nearness = np.minimum(1.0, np.maximum(0.0, RIM_SLOPE * (1.0 - depths)))
        factors: FloatArray = 1.0 + 0.5 * rim_stretch * (nearness[:, None] + nearness)
        return factors

    def _step(self, centers: FloatArray, stretch: float | FloatArray, limit: float) -> FloatArray:
        """Return the centers after one iteration, `limit` being the longest step as a share of the largest allowed."""
        law = self._law
        force = law.between(centers, stretch) + law.shape_gain * self._contour.at(centers).repulsion
        longest = limit * self._config.step_max * law.base
        steps = law.mobility * force
        lengths = np.sqrt((steps * steps).sum(axis=1))
        steps *= np.minimum(1.0, longest / np.maximum(lengths, longest))[:, None]
        return self._separator.apart(on_grid(centers + steps), SWEEPS)

    def _pressures(self, centers: FloatArray) -> FloatArray:
        """Return how hard each bubble is pushed from all sides together, (n,), rounded: some are equal by symmetry."""
        push = self._law.shape_gain * self._contour.at(centers).repulsion
        return on_grid(self._law.pressures(centers) + np.sqrt((push * push).sum(axis=1)))
