"""The swarm at one moment, as whoever looks on sees it: the same for all families, in a terminal and in a browser.

Each family brings `Scenes` (`bringup.family.Behavior.scenes`), which turn its ticks into this; `bringup.dashboard` and
`bringup.live_view` show it and know no family.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from bringup.engine import TickRecord
from swarm_msgs_py.types import FloatArray, NodeId

Rgb = tuple[float, float, float]
RESTING, MOVING, HELD_UP, ASTRAY, IDLE, UNREADY = (
    (0.0, 0.62, 0.45),
    (0.0, 0.45, 0.7),
    (0.9, 0.6, 0.0),
    (0.8, 0.47, 0.65),
    (0.94, 0.89, 0.26),
    (0.83, 0.37, 0.0),
)
"""Colors of states, safe for color blindness: done, under way, held up, lost, with nothing to do, not ready yet."""
GONE = (0.65, 0.65, 0.65)
STYLES: Mapping[Rgb, str] = {
    RESTING: "green",
    MOVING: "cyan",
    HELD_UP: "yellow",
    ASTRAY: "magenta",
    IDLE: "yellow",
    UNREADY: "red",
    GONE: "bold red",
}
"""What a terminal shows for them."""
ALARM, UNDER_WAY, WELL = 0, 1, 2
"""How much attention a robot needs, most first."""


@dataclass(frozen=True, slots=True)
class RobotView:
    """One robot.

    Attributes
    ----------
    robot : NodeId
    state : str
        What it does, in a word or two.
    color : tuple of float
        Of that state, RGB from 0 to 1.
    attention : (int, float)
        `ALARM`, `UNDER_WAY` or `WELL`, then what puts it before or behind its like: lower first.
    facts : tuple
        Text, number or None, one for each of `Scenes.columns`.
    """

    robot: NodeId
    state: str
    color: Rgb
    attention: tuple[int, float]
    facts: tuple[str | float | int | None, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """All of it; d is 2 or 3.

    Attributes
    ----------
    robots : tuple of RobotView
        In the order of the positions.
    positions : (n, d) array
        True ones [m].
    links : tuple of (int, int)
        Rows of robots that hear or hold each other.
    places : (g, d) array
        Where robots are wanted [m].
    outlines : tuple of (k, d) array
        Closed lines: of the shape as it is now [m].
    """

    robots: tuple[RobotView, ...]
    positions: FloatArray
    links: tuple[tuple[int, int], ...] = ()
    places: FloatArray = field(default_factory=lambda: np.empty((0, 2)))
    outlines: tuple[FloatArray, ...] = ()


class Scenes(Protocol):
    """Turns the ticks of one run into scenes."""

    @property
    def columns(self) -> tuple[str, ...]:
        """What `RobotView.facts` are, with units."""
        ...

    @property
    def radii(self) -> FloatArray:
        """Size of each robot, (n,) [m]."""
        ...

    @property
    def walls(self) -> tuple[FloatArray, ...]:
        """Closed lines around what is in the way, (k, d) each [m]."""
        ...

    def take(self, record: TickRecord[Any, Any]) -> Scene:
        """Take in one tick, and return how things are in it."""
        ...


def absent(robot: NodeId, columns: tuple[str, ...], *, is_alive: bool) -> RobotView:
    """Return a robot that has said nothing: it is off, or silent."""
    state, color = ("silent", UNREADY) if is_alive else ("off", GONE)
    return RobotView(robot, state, color, (ALARM, float(robot)), (None,) * len(columns))
