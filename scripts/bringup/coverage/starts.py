"""Where point robots start."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.metrics.coverage import close_pairs, component_count

LEADER = NodeId(0)
START_EDGE = 70.0  # of the cube in which the followers start (eq. (9)) [m]
DRAWS = 1000  # of starts until one is connected


def start_positions(robots: int, link: float, seed: int, edge: float) -> FloatArray:
    """Return the leader at the origin and followers in the cube of eq. (9), drawn anew until they are connected.

    Parameters
    ----------
    robots : int
        The leader included.
    link, edge : float
        r_sc and the edge of the cube [m].
    seed : int

    Raises
    ------
    ConfigError
        If no draw is connected.
    """
    rng = rng_for(seed, "coverage", "start")
    for _ in range(DRAWS):
        positions = np.concatenate([np.zeros((1, 3)), edge * rng.random((robots - 1, 3))])
        if component_count(robots, close_pairs(positions, link)) == 1:
            return positions
    raise ConfigError(
        f"{robots} robots in a cube of {edge:g} m are not connected by links of {link:g} m in any of {DRAWS} draws; "
        "lower robots.start_edge_m, or take more robots"
    )
