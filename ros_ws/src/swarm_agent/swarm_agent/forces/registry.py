"""The force law of a name, settings, shape and obstacles; robots in one process share it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.force_law import ForceLaw
from swarm_agent.forces.literal_law import LiteralLaw
from swarm_agent.forces.sharing_law import SharingLaw
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.types import FloatArray

LAWS_KEPT = 8  # shapes and maps in use at one time; a moving shape makes a new one every tick


def law_for(
    name: ForceLawName,
    config: ForceConfig,
    contour: FloatArray,
    obstacles: tuple[FloatArray, ...],
    planning: PlanningConfig,
) -> ForceLaw:
    """Return the force law of a name; equal content gives the same object.

    Parameters
    ----------
    name : ForceLawName
    config : ForceConfig
    contour : (k, 2) array
        Desired shape, simple and counter-clockwise [m].
    obstacles : tuple of (m, 2) array
        Outlines [m].
    planning : PlanningConfig
        How far paths keep from obstacles.
    """
    return _law(name, config, _bytes(contour), tuple(_bytes(obstacle) for obstacle in obstacles), planning)


def _bytes(points: FloatArray) -> bytes:
    return np.asarray(points, dtype=np.float64).tobytes()


@lru_cache(maxsize=LAWS_KEPT)
def _law(
    name: ForceLawName, config: ForceConfig, contour: bytes, obstacles: tuple[bytes, ...], planning: PlanningConfig
) -> ForceLaw:
    shape, *outlines = (np.frombuffer(raw, dtype=np.float64).reshape(-1, 2) for raw in (contour, *obstacles))
    if name is ForceLawName.LITERAL:
        return LiteralLaw(config.literal, shape, outlines, config.substep_s)
    return SharingLaw(config, shape, outlines, planning)
