"""What all who steer a boat in continuous space share: settings, the contract of a tick, driving to a cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.assembly.boat_frames import BoatFrame
from swarm_msgs_py.assembly.faces import Cell, Face, turned_face
from swarm_msgs_py.assembly.progress_frames import ProgressFrame
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.types import FloatArray

QUARTER_RAD = 0.5 * np.pi
"""A quarter turn [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SkipperConfig(Config):
    """How boats follow guideposts in continuous space."""

    cell_m: float = setting(0.25, "edge of a grid cell (paper)", unit="m", above=0.0)
    cruise_mps: float = setting(0.15, "speed from cell to cell", unit="m/s", above=0.0, maximum=1.0)
    docking_mps: float = setting(0.05, "speed on the last stretch to a partner", unit="m/s", above=0.0, maximum=1.0)
    docking_stretch_m: float = setting(0.10, "how long that stretch is", unit="m", minimum=0.0)
    turn_radps: float = setting(0.5, "rate of turning to the orientation of the dispatch", unit="rad/s", above=0.0)
    arrival_m: float = setting(0.04, "a boat nearer to a cell's center has arrived", unit="m", above=0.0)
    arrival_deg: float = setting(6.0, "and turned by no more than this", unit="deg", above=0.0)
    notice_ticks: int = setting(
        2, "ticks between a group's announcement and its departure, so that members hear it twice", minimum=1
    )
    docking_patience_s: float = setting(
        15.0, "groups that met and do not hold together for so long are stuck", unit="s", minimum=1.0, maximum=600.0
    )
    talk_ticks: int = setting(
        2, "boats that find their ways by themselves say everything so often", minimum=1, maximum=10
    )
    settle_s: float = setting(
        0.75, "and stand so long at the end of each step, for the water to calm down", unit="s", minimum=0.0
    )
    silence_s: float = setting(
        5.0, "a boat that was not heard for so long is taken for dead", unit="s", minimum=1.0, maximum=600.0
    )


@dataclass(frozen=True, slots=True, eq=False)
class SkipperInputs:
    """What a boat learns in one tick.

    Attributes
    ----------
    tick : int
    pose : (3,) array
        Measured x, y [m] and heading [rad], world frame.
    reference : (3,) array
        The pose that its firmware holds now.
    contacts : frozenset of Face
        Sides whose foils are pressed, in the boat's own frame.
    frames : sequence of ProgressFrame
        Heard since the last tick.
    words : sequence of BoatFrame
        Heard since the last tick, of boats that find their ways by themselves.
    seen : sequence of (float, float)
        Places of other hulls around [m].
    """

    tick: int
    pose: FloatArray
    reference: FloatArray
    contacts: frozenset[Face]
    frames: Sequence[ProgressFrame]
    words: Sequence[BoatFrame] = ()
    seen: Sequence[tuple[float, float]] = ()


@dataclass(frozen=True, slots=True, eq=False)
class SkipperOutputs:
    """What a boat does and says.

    Attributes
    ----------
    velocity : (3,) array
        Of the reference, world frame [m/s], [rad/s].
    frame : ProgressFrame
    is_done : bool
        It is at its target, and its group holds together.
    goal : (2,) array
        Where it is driving [m].
    word : BoatFrame or None
        What it says to boats that find their ways by themselves.
    """

    velocity: FloatArray
    frame: ProgressFrame
    is_done: bool
    goal: FloatArray
    word: BoatFrame | None = None


def start_heading(heading: float, turns: int) -> float:
    """Return the heading [rad] that is `turns` clockwise quarter turns from the nearest quarter to `heading`."""
    return QUARTER_RAD * (round(heading / QUARTER_RAD) - turns)


def has_arrived(config: SkipperConfig, target: FloatArray, inputs: SkipperInputs) -> bool:
    """Return whether the reference is at the target pose (3,), and the boat is near enough to it."""
    gap = target - inputs.reference
    gap[2] = _wrapped(gap[2])
    off = target - inputs.pose
    is_near = np.hypot(off[0], off[1]) < config.arrival_m
    is_turned = abs(_wrapped(off[2])) < np.radians(config.arrival_deg)
    return bool(np.abs(gap).max() < 1e-6 and is_near and is_turned)


def steered(
    config: SkipperConfig, target: FloatArray, reference: FloatArray, period_s: float, *, is_docking: bool
) -> FloatArray:
    """Return how the reference is to move in this tick: straight to its target, slowly where partners meet.

    Returns
    -------
    (3,) array
        World frame [m/s], [rad/s].
    """
    gap = target - reference
    distance = float(np.hypot(gap[0], gap[1]))
    reach = config.cruise_mps * period_s
    if is_docking:
        reach = min(reach, max(config.docking_mps * period_s, distance - config.docking_stretch_m))
    planar = gap[:2] * min(1.0, reach / distance) if distance > 0.0 else np.zeros(2)
    turn = _wrapped(gap[2])
    turn = float(np.clip(turn, -config.turn_radps * period_s, config.turn_radps * period_s))
    return np.array([planar[0], planar[1], turn]) / period_s


def cell_at(config: SkipperConfig, place: FloatArray) -> Cell:
    """Return the cell around a place (2,) [m]."""
    return round(float(place[0]) / config.cell_m), round(float(place[1]) / config.cell_m)


def grid_faces(contacts: frozenset[Face], heading: float) -> frozenset[Face]:
    """Return the sides of its cell to which a boat's own sides look, given its heading [rad]."""
    clockwise = -round(heading / QUARTER_RAD)
    return frozenset(turned_face(face, clockwise) for face in contacts)


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
