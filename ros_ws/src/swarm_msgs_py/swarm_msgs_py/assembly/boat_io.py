"""The step contract of the assembly family: what a boat is given each tick, and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.types import FloatArray


class BoatMode(IntEnum):
    """What a boat is doing."""

    IDLE = 0  # without a target
    WAITING = 1  # until others have passed, or its group is complete
    MOVING = 2
    DOCKED = 3  # at its target, in a group that holds together


@dataclass(frozen=True, slots=True, eq=False)
class AssemblyInputs:
    """All that one boat learns in one tick.

    Attributes
    ----------
    tick : int
    time : float
        Simulated time [s].
    pose : (3,) array
        Measured x, y [m] and heading [rad], world frame.
    reference : (3,) array
        The pose that its firmware holds now.
    contacts : frozenset of Face
        Sides whose foils are pressed, in the boat's own frame.
    inbox : tuple of bytes
        Frames heard since the last tick, in order of reception.
    seen : (k, 2) array
        Measured places of the other hulls around [m], ascending.
    """

    tick: int
    time: float
    pose: FloatArray
    reference: FloatArray
    contacts: frozenset[Face]
    inbox: tuple[bytes, ...]
    seen: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))


@dataclass(frozen=True, slots=True, eq=False)
class AssemblyReport:
    """What a boat says of itself, for people and metrics; nothing in the swarm depends on it.

    Attributes
    ----------
    mode : BoatMode
    epoch : int
        Plan that it follows, 0 for none.
    steps_done : int
        Of the plan.
    steps : int
        That the plan has.
    pose : (3,) array
        Measured.
    contacts : frozenset of Face
    goal : (2,) array
        Where it is driving [m].
    """

    mode: BoatMode
    epoch: int
    steps_done: int
    steps: int
    pose: FloatArray
    contacts: frozenset[Face]
    goal: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class AssemblyOutputs:
    """What one boat does in one tick.

    Attributes
    ----------
    tick : int
    command : (3,) array
        Velocity of the pose that the firmware is to hold, world frame [m/s], [rad/s].
    outbox : tuple of bytes
        Frames to transmit.
    report : AssemblyReport
    """

    tick: int
    command: FloatArray
    outbox: tuple[bytes, ...]
    report: AssemblyReport
