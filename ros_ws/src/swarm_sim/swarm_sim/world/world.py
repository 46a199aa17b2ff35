"""The contract of a physics back end: true states in, one control period of motion out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from swarm_msgs_py.types import FloatArray, IntArray

SAMPLE_HZ = 20.0
"""Least rate at which motion within a tick is sampled for viewers and clearance [Hz]."""


@dataclass(frozen=True, slots=True, eq=False)
class BodyState:
    """True state of every body at one instant, in the scene's order of robots.

    Attributes
    ----------
    positions : (n, 2) array
        Centers, world frame [m].
    heights : (n,) array
        Height of the center above the datum of the ground [m].
    yaws : (n,) array
        Headings in [-pi, pi) [rad].
    velocities : (n, 2) array
        World frame [m/s].
    yaw_rates : (n,) array
        [rad/s].
    """

    positions: FloatArray
    heights: FloatArray
    yaws: FloatArray
    velocities: FloatArray
    yaw_rates: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """What happened in one control period.

    Attributes
    ----------
    start, end : BodyState
    samples, sample_velocities : (m, n, 2) array
        Positions [m] and velocities [m/s] at m instants, evenly spread at `SAMPLE_HZ` or more, the last at the end.
    mean_accelerations : (n, 2) array
        Velocity increment over the period, world frame [m/s^2].
    """

    start: BodyState
    end: BodyState
    samples: FloatArray
    sample_velocities: FloatArray
    mean_accelerations: FloatArray


class World(Protocol):
    """Bodies that a velocity servo drives; one implementation per physics back end."""

    has_contacts: bool
    """Whether robots and walls stop each other; without, overlaps are possible and are reported."""

    @property
    def state(self) -> BodyState:
        """Return the true state now."""
        ...

    def advance(self, setpoints: FloatArray) -> Motion:
        """Run one control period under constant setpoints.

        Parameters
        ----------
        setpoints : (n, 3) array
            Forward and left velocity, body frame [m/s], and turn rate [rad/s] of every robot.

        Raises
        ------
        PhysicsError
            If the world is closed, or a body left the ground.
        """
        ...

    def close(self) -> None:
        """Free what the back end holds; may be called again."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class TickGrid:
    """How a control period is cut into physics steps and samples.

    Attributes
    ----------
    period_s : float
        Control period [s].
    steps : int
        Physics steps in it.
    step_s : float
        Length of a step [s]; at most 1 / rate, so that the steps fill the period exactly.
    sampled : (m,) int array
        Steps after which a sample is taken, the last of them the last step.
    """

    period_s: float
    steps: int
    step_s: float
    sampled: IntArray

    @classmethod
    def of(cls, period_s: float, rate_hz: float) -> TickGrid:
        """Return the grid of one control period."""
        steps = math.ceil(period_s * rate_hz - 1e-9)
        samples = min(steps, math.ceil(period_s * SAMPLE_HZ - 1e-9))
        # Rounding up keeps every gap at or below its fair share of steps, except where the rate is too low for it.
        sampled = -(-np.arange(1, samples + 1) * steps // samples)
        return cls(period_s, steps, period_s / steps, sampled.astype(np.int64))


def frozen(array: FloatArray) -> FloatArray:
    """Return a read-only copy, so that no observer can change the truth."""
    copy = np.array(array, dtype=np.float64)
    copy.flags.writeable = False
    return copy


def motion_between(
    start: BodyState, end: BodyState, samples: FloatArray, sample_velocities: FloatArray, period_s: float
) -> Motion:
    """Return the record of a control period."""
    gained = frozen((end.velocities - start.velocities) / period_s)
    return Motion(start, end, frozen(samples), frozen(sample_velocities), gained)
