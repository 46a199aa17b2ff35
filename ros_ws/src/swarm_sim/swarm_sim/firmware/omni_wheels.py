"""Three omni wheels at 120 degrees: from a body velocity to rim speeds and back, step motors, and slip.

The thesis writes the rim speeds as ``V_k = |v| cos(a_k - alpha)`` with alpha the direction of motion, clockwise from
the front, and a_k = 150, 30, 270 degrees (section 5.1). These are the clockwise tangents of wheels that are mounted at
the clockwise bearings 60, 300 and 180 degrees. A turn term, which the thesis lacks (erratum E33), adds the same rim
speed to all three.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.types import FloatArray
from swarm_sim.config import OmniConfig

WHEEL_TANGENTS = np.deg2rad([150.0, 30.0, 270.0])
"""Directions in which wheels A, B and C roll, clockwise from the front [rad]."""
WHEEL_BEARINGS = np.deg2rad([60.0, 300.0, 180.0])
"""Where they are mounted, clockwise from the front [rad]."""
WHOLE = 1e-9
"""What a multiple may lack of a whole number by rounding."""


def mixing_matrices(levers: FloatArray) -> FloatArray:
    """Return what turns body velocities (forward, left, turn rate) into rim speeds (A, B, C).

    Parameters
    ----------
    levers : (n,) array
        Distance of the wheels from the middle of each robot [m].

    Returns
    -------
    (n, 3, 3) array
        Its transpose turns rim forces into a body wrench (forward, left, torque), since power is the same.
    """
    mixing = np.empty((len(levers), 3, 3))
    mixing[:, :, 0] = np.cos(WHEEL_TANGENTS)
    mixing[:, :, 1] = -np.sin(WHEEL_TANGENTS)  # the thesis counts to the right, the body frame (REP 103) to the left
    mixing[:, :, 2] = -levers[:, None]  # rims turn clockwise, yaw counter-clockwise
    return mixing


def unmixing_matrices(levers: FloatArray) -> FloatArray:
    """Return what turns rim speeds into body velocities (n, 3, 3): the inverse of the mixing, in closed form."""
    unmixing = np.empty((len(levers), 3, 3))
    unmixing[:, 0] = 2.0 / 3.0 * np.cos(WHEEL_TANGENTS)
    unmixing[:, 1] = -2.0 / 3.0 * np.sin(WHEEL_TANGENTS)
    unmixing[:, 2] = -1.0 / (3.0 * levers[:, None])
    return unmixing


def apply(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return the product (n, 3) of each matrix (n, 3, 3) with its vector (n, 3)."""
    product: FloatArray = np.einsum("nij,nj->ni", matrices, vectors)
    return product


class StepMotors:
    """The step motors of all robots: rates in whole multiples of a resolution, bounded, reached by a ramp.

    What is commanded to a motor is a whole multiple, and so is its bound; its ramp to there is continuous.

    Parameters
    ----------
    config : OmniConfig
    levers : (n,) array
        [m].
    step_s : float
        Time between two calls [s].
    """

    def __init__(self, config: OmniConfig, levers: FloatArray, step_s: float) -> None:
        self._mixing = mixing_matrices(levers)
        self._rim_per_step = 2.0 * np.pi * config.wheel_radius_m / config.steps_per_turn
        self._resolution = config.rate_resolution_hz
        self._rate_max = math.floor(config.rate_max_hz / self._resolution + WHOLE) * self._resolution
        self._ramp = config.rate_ramp_hzps * step_s
        self.rates: FloatArray = np.zeros((len(levers), 3))
        """Steps per second of every motor now, clockwise positive."""

    def wanted_rates(self, setpoints: FloatArray) -> FloatArray:
        """Return the step rates that body velocities (n, 3) ask for, saturated and rounded to the resolution [Hz].

        Saturation slows all three wheels of a robot by one factor, so that it goes slower, not elsewhere.
        """
        rates = apply(self._mixing, setpoints) / self._rim_per_step
        fastest = np.abs(rates).max(axis=1, keepdims=True)
        rates *= self._rate_max / np.maximum(fastest, self._rate_max)
        rounded: FloatArray = np.rint(rates / self._resolution) * self._resolution
        return rounded

    def advance(self, setpoints: FloatArray) -> FloatArray:
        """Run one firmware step towards body velocities (n, 3) [m/s], [rad/s]; return the rim speeds (n, 3) [m/s].

        A motor that is accelerated too fast loses steps. The ramp moves the three rates of a robot along a straight
        line, so that it neither turns nor leaves its course while it speeds up.
        """
        change = self.wanted_rates(setpoints) - self.rates
        largest = np.abs(change).max(axis=1, keepdims=True)
        self.rates = self.rates + change * (self._ramp / np.maximum(largest, self._ramp))
        return self.rates * self._rim_per_step


class WheelSlip:
    """How much of its rim speed each wheel really moves: a noise with a memory, as floor and rollers make it.

    The slip of a wheel is a stationary first-order Gauss-Markov process; its step is exact for any step length.

    Parameters
    ----------
    config : OmniConfig
    robots : int
    step_s : float
        Time between two calls [s].
    rng : Generator
        The stream that slip is drawn from.
    """

    def __init__(self, config: OmniConfig, robots: int, step_s: float, rng: np.random.Generator) -> None:
        self._keep = float(np.exp(-step_s / config.slip_time_s))
        self._kick = config.slip_sigma * float(np.sqrt(1.0 - self._keep**2))
        self._rng = rng
        self._slip = config.slip_sigma * rng.normal(size=(robots, 3))

    def advance(self) -> FloatArray:
        """Return the factors (n, 3) on the rim speeds of the next step."""
        self._slip = self._keep * self._slip + self._kick * self._rng.normal(size=self._slip.shape)
        return 1.0 - self._slip
