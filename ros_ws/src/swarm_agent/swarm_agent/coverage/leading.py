"""What the leader alone knows and does: it holds the shape, finds it, and lays places out."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.frames import on_air
from swarm_agent.coverage.layout import plan_layout
from swarm_agent.coverage.sense_sphere import directions_of
from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.description import solid_from, unpacked_description
from swarm_msgs_py.geometry.solids.sampling import interior_points
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

GUIDES = 4000  # points of the shape among which the nearest is sought


class Leading:
    """The leader's part.

    Parameters
    ----------
    shape : bytes
        Packed description of the shape to cover.
    seed : int

    Raises
    ------
    FrameError, ShapeError
        If the bytes describe no solid.
    """

    def __init__(self, shape: bytes, seed: int) -> None:
        self._seed = seed
        self._solid = solid_from(unpacked_description(shape))
        self.shape = shape
        self._guides = interior_points(self._solid, GUIDES, rng_for(self._seed, "coverage", "guides"))

    def approach(self, position: FloatArray, config: CoverageConfig, period: float) -> FloatArray | None:
        """Return the slow velocity toward the shape, None once the sense sphere meets it [I7].

        Parameters
        ----------
        position : (3,) array
            Where the leader is [m].
        config : CoverageConfig
        period : float
            Of a tick [s].
        """
        if self._solid.contains(position + config.range_m * directions_of(config)).any():
            return None
        offsets = self._guides - position
        distances = np.linalg.norm(offsets, axis=1)
        if float(distances.min()) <= config.motion.approach_mps * period:  # the shape is within the own coverage
            return None
        nearest = int(distances.argmin())
        velocity: FloatArray = offsets[nearest] * (config.motion.approach_mps / distances[nearest])
        return velocity

    def places(
        self, position: FloatArray, config: CoverageConfig, barriers: Barriers = OPEN_SPACE
    ) -> list[tuple[float, float, float]]:
        """Return the places of the layout rule for a leader at `position` (3,) [m], its own left out."""
        layout = plan_layout(self._solid, position, config, self._seed, barriers)
        return [on_air(place) for place in layout.positions[1:]]


@lru_cache(maxsize=16)
def solid_of(shape: bytes) -> Solid | None:
    """Return the solid that a mission describes, None if it describes none."""
    try:
        return solid_from(unpacked_description(shape))
    except (FrameError, ShapeError):
        return None
