"""A partition method: goals where the seeds of a sunflower are."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.geometry.contour import area_centroid
from swarm_msgs_py.partition import PartitionConfig
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.separation import FINAL_SWEEPS, Separator
from swarm_msgs_py.types import FloatArray

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))
SEEDS = 20  # per robot, so that enough of them are inside a shape that is far from round
SWEEPS = 40  # halvings of the spacing's range


class Sunflower:
    """Seeds on a spiral around the center of area, as wide as they can be with one inside the shape for every robot.

    Parameters
    ----------
    config : PartitionConfig
        All settings of partitions; this method has none of its own.

    References
    ----------
    .. [1] H. Vogel, "A better way to construct the sunflower head", Mathematical Biosciences 44, 1979.
    """

    def __init__(self, config: PartitionConfig) -> None:
        self._config = config

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the last circle if there is no room for all, else None."""
        count = len(domain.radii)
        return Shortage.after(domain, np.arange(count), count - 1) if self.place(domain) is None else None

    def place(self, domain: Domain) -> FloatArray | None:
        """Return the (n, 2) centers, which keep all gaps of the domain, or None if there is no room."""
        if any(region.is_empty for region in domain.regions):
            return None
        count, widest = len(domain.radii), domain.regions[-1]  # the region of the largest robots is the smallest
        number = np.arange(SEEDS * count)
        seeds = np.sqrt(number + 0.5)[:, None] * np.column_stack(
            [np.cos(GOLDEN_ANGLE * number), np.sin(GOLDEN_ANGLE * number)]
        )
        center, low, high = area_centroid(domain.contour), 0.0, math.sqrt(domain.area)
        for _ in range(SWEEPS):
            spacing = 0.5 * (low + high)
            enough = widest.contains(center + spacing * seeds).sum() >= count
            low, high = (spacing, high) if enough else (low, spacing)
        inside = widest.contains(center + low * seeds)
        if inside.sum() < count:
            return None
        separator = Separator(domain)
        centers = separator.apart((center + low * seeds)[inside][:count], FINAL_SWEEPS)
        return centers if separator.is_separated(centers) else None
