"""The robots that one robot senses in a tick, looked up by number."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.types import FloatArray, NodeId


class Surroundings:
    """What a robot senses of others; made from the inputs of each tick, and computed only as far as it is asked.

    Parameters
    ----------
    inputs : CoverageInputs
    """

    def __init__(self, inputs: CoverageInputs) -> None:
        self.ids, self.offsets = inputs.ids, inputs.offsets

    @cached_property
    def robots(self) -> dict[NodeId, int]:
        """Row of each robot that is sensed."""
        return {NodeId(robot): row for row, robot in enumerate(self.ids.tolist())}

    @cached_property
    def distances(self) -> FloatArray:
        """How far away they are, (k,) [m]."""
        lengths: FloatArray = np.sqrt(np.einsum("ij,ij->i", self.offsets, self.offsets))
        return lengths

    def offset(self, robot: NodeId) -> FloatArray | None:
        """Return where a robot is, relative to this one, (3,) [m]; None if it is not sensed."""
        row = int(np.searchsorted(self.ids, robot))
        if row == len(self.ids) or self.ids[row] != robot:
            return None
        offset: FloatArray = self.offsets[row]
        return offset

    def distance(self, robot: NodeId) -> float:
        """Return how far away a robot is [m], infinite if it is not sensed."""
        offset = self.offset(robot)
        return float("inf") if offset is None else float(np.sqrt(offset @ offset))
