"""Names of nodes, as alerts and errors print them, and distances as results do."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from swarm_msgs_py.types import MISSION, NodeId, node_name, robot_name

LISTED_MAX = 12  # nodes that are listed one by one
CENTIMETER = 0.01  # below this, distances are told in millimeters [m]
NAMED_MAX = 4  # things that a one-line error or reason names


def node_list(nodes: Sequence[NodeId]) -> str:
    """Return the names of some nodes, as short as is still exact.

    Many robots whose numbers are evenly spaced, as those of one process are, are told by the first, the last and the
    step: ``r01 to r49 in steps of 2 (25 robots)``. All others are listed.

    Parameters
    ----------
    nodes : sequence of NodeId
        Ascending.
    """
    steps = {after - before for before, after in pairwise(nodes)}
    if len(nodes) <= LISTED_MAX or len(steps) != 1 or nodes[-1] == MISSION:
        return ", ".join(map(node_name, nodes))
    (step,) = steps
    spacing = "" if step == 1 else f" in steps of {step}"
    return f"{robot_name(nodes[0])} to {robot_name(nodes[-1])}{spacing} ({len(nodes)} robots)"


def first_few(names: Sequence[str]) -> str:
    """Return some names in a line that is short however many there are: the first ones, and ``...`` for the rest."""
    return ", ".join([*names[:NAMED_MAX], *(["..."] if len(names) > NAMED_MAX else [])])


def distance_text(distance_m: float | None) -> str:
    """Return a distance for people, in millimeters below a centimeter; a dash for none."""
    if distance_m is None:
        return "-"
    return f"{1000.0 * distance_m:.1f} mm" if distance_m < CENTIMETER else f"{distance_m:.3f} m"
