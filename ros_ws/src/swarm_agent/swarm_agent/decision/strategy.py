"""What varies between formation methods on the robot: where it should be, given what it knows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """Outcome of one decision tick.

    Attributes
    ----------
    goal : int
        Goal id in the plan, -1 for none.
    destination : (2,) array or None
        Where to drive [m]; None to stand still.
    mode : Mode
        What the robot is doing, as far as the decision knows (it may turn out to be parked or blocked).
    obstacles : tuple of (m, 2) array
        Map to plan the path on [m].
    """

    goal: int
    destination: FloatArray | None
    mode: Mode
    obstacles: tuple[FloatArray, ...]


class Strategy(Protocol):
    """Decides where the robot should be, once per tick."""

    def step(self, tick: int, position: FloatArray, takes_part: bool = True, is_blocked: bool = False) -> Decision:
        """Return the decision for this tick.

        Parameters
        ----------
        tick : int
        position : (2,) array
            The robot's own estimate [m].
        takes_part : bool
            Whether the robot is there for a goal; if not, it withdraws until it is again.
        is_blocked : bool
            Whether the robot is hardly getting on, for what is in its way.
        """
        ...
