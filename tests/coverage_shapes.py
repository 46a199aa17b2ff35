"""The shapes of the 3D coverage paper's experiments, and what tests ask of layouts."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import FloatArray

EDGE = 200.0 / 3.0  # 66.7 m
BALL: Solid = solid_from({"kind": "ball", "radius_m": 100.0})
BEAM: Solid = solid_from({"kind": "box", "size_m": [300.0, EDGE, EDGE]})
CROSS: Solid = solid_from(
    {
        "kind": "union",
        "of": [{"kind": "box", "size_m": [300.0, EDGE, EDGE]}, {"kind": "box", "size_m": [EDGE, EDGE, 200.0]}],
    }
)
EXPERIMENTS: dict[str, tuple[Solid, float]] = {
    "ball": (BALL, 50.0),
    "ball70": (BALL, 70.0),
    "box": (BEAM, 50.0),
    "cross": (CROSS, 50.0),
}
"""Shape and r_sc [m] of experiments E1 to E4."""


def nearest_pair(positions: FloatArray) -> float:
    """Return the least distance between two of `positions` (n, 3) [m]."""
    distances = np.linalg.norm(positions[:, None] - positions, axis=2)
    return float(distances[np.triu_indices(len(positions), k=1)].min())
