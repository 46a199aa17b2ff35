"""What a partition method is, and the one registry of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from swarm_msgs_py.extensions import PARTITION_METHODS, extension
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.config import Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.fractals import RandomizedFractals
from swarm_msgs_py.partition.voronoi import CentroidalVoronoi
from swarm_msgs_py.types import FloatArray


class PartitionMethod(Protocol):
    """Finds room for circles inside a contour; equal inputs give equal results."""

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the circle for which there is no room; None: `place` will find room for all, and not return None."""
        ...

    def place(self, domain: Domain) -> FloatArray | None:
        """Return the (n, 2) centers, which keep all gaps of the domain, or None if there is no room."""
        ...


METHODS: Mapping[Method, Callable[[PartitionConfig], PartitionMethod]] = {
    Method.BUBBLE_PACKING: lambda config: BubblePacking(config.bubbles),
    Method.FRACTALS: lambda config: RandomizedFractals(config.fractals),
    Method.VORONOI: lambda config: CentroidalVoronoi(config.voronoi, config.bubbles),
}
"""How to make each method from its settings."""


def method_for(config: PartitionConfig) -> PartitionMethod:
    """Return the method that the settings name, one of those here or one that an installed package adds.

    Raises
    ------
    ConfigError
        If there is no such extension.
    """
    if config.extension is None:
        return METHODS[config.method](config)
    made: PartitionMethod = extension(PARTITION_METHODS, config.extension)(config)
    return made
