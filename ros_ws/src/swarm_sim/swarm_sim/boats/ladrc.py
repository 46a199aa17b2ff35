"""Linear active disturbance rejection: an observer of what is not modeled, and PD (paper, eqs. 11-24).

Per axis, the observer follows pose, velocity and the lumped rest f of ``eta'' = f + B u``, and the law takes f away::

    e = y - z1,   z1' = z2 + a1 e,   z2' = z3 + a + a2 e,   z3' = a3 e
    a = kp (r - z1) + kd (r' - z2) + r'' - z3

with `a` the acceleration that the limited thrusters make. The paper asks for positive gains; the observer is stable if
and only if also ``a1 a2 > a3`` (Routh). Steps use the exact solution for a measurement and an input that are held.

Docked boats each hold their own place. As a group has the mass and, about its center, the inertia of its members at
their places, equal gains of all make the group as stiff as one boat, whoever leads it. Only one thing would go wrong:
two places that do not fit together by a millimeter would wind up two observers against each other. So the observer of a
docked boat forgets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.boats.pose_control import Reference, pose_error

AXES = 3
DOCKED_LEAK = 0.3
"""Rate at which a docked boat's disturbance estimate decays [1/s].

With the tuned gains it costs a tenth of a millimeter of accuracy under 0.1 N, and bounds the inner force of two places
that do not fit by a millimeter to about a newton; ten times the rate would cost a millimeter and bound it to 0.1 N.
"""


@dataclass(frozen=True, slots=True)
class Bandwidths:
    """Gains of an axis in terms of bandwidths, all poles of the observer at one place.

    Attributes
    ----------
    control, observer : float
        [rad/s]
    damping : float
        Of the control loop; 1 is critical.
    lead : float
        See `LadrcGains.thruster_lead`.
    """

    control: float
    observer: float
    damping: float = 1.0
    lead: float = 1.0

    @property
    def rate_gain(self) -> float:
        """Kd [1/s]."""
        return 2.0 * self.damping * self.control


@dataclass(frozen=True, slots=True)
class LadrcGains:
    """Gains per axis x, y, yaw.

    Attributes
    ----------
    stiffness, damping : tuple of float
        kp [1/s^2] and kd [1/s].
    observer : tuple of (float, float, float)
        a1 [1/s], a2 [1/s^2] and a3 [1/s^3] of each axis.
    thruster_lead : tuple of float
        How many times faster than by themselves the thrusters are to follow, 1 or more (not in the paper, which has no
        lag): what the observer's model of them says that they give now is told apart from what they are asked for.

    Raises
    ------
    ConfigError
        If a loop or an observer would be unstable.
    """

    stiffness: tuple[float, float, float]
    damping: tuple[float, float, float]
    observer: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
    thruster_lead: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check Routh's criterion, axis by axis."""
        for axis, (a1, a2, a3) in enumerate(self.observer):
            if min(a1, a2, a3) <= 0.0 or a1 * a2 <= a3:
                raise ConfigError(
                    f"observer gains {(a1, a2, a3)} of axis {axis} are unstable; they must be positive and a1 a2 > a3"
                )
            if min(self.stiffness[axis], self.damping[axis]) <= 0.0:
                raise ConfigError(f"control gains of axis {axis} must be positive")

    @classmethod
    def of_bandwidths(cls, planar: Bandwidths, yaw: Bandwidths) -> LadrcGains:
        """Return gains for x and y, which are alike, and for yaw."""
        axes = (planar, planar, yaw)
        first, second, third = ((3.0 * b.observer, 3.0 * b.observer**2, b.observer**3) for b in axes)
        return cls(
            (planar.control**2, planar.control**2, yaw.control**2),
            (planar.rate_gain, planar.rate_gain, yaw.rate_gain),
            (first, second, third),
            (planar.lead, planar.lead, yaw.lead),
        )


PAPER_GAINS = LadrcGains(
    (1600.0, 1600.0, 144.0), (80.0, 80.0, 24.0), ((30.0, 300.0, 300.0),) * 2 + ((9.0, 27.0, 27.0),)
)
"""Table I, its first index read as the axis (digest, section 3)."""


def observer_matrices(gains: LadrcGains, step_s: float, leak: float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return the observers of the three axes, sampled.

    Returns
    -------
    transition : (3, 3, 3) array
        Of the states [z1, z2, z3] of each axis over a step.
    response : (3, 3, 2) array
        To the measurement and to the acceleration, both held over the step.
    """
    transition, response = np.empty((AXES, 3, 3)), np.empty((AXES, 3, 2))
    for axis, (a1, a2, a3) in enumerate(gains.observer):
        block = np.zeros((5, 5))
        block[:3, :3] = [[-a1, 1.0, 0.0], [-a2, 0.0, 1.0], [-a3, 0.0, -leak]]
        block[:3, 3] = a1, a2, a3
        block[1, 4] = 1.0
        sampled = expm(block * step_s)
        transition[axis], response[axis] = sampled[:3, :3], sampled[:3, 3:]
    return transition, response


class Ladrc:
    """The law for n boats; implements `PoseController`.

    Parameters
    ----------
    gains : sequence of LadrcGains
        Of each boat, or one for all.
    poses : (n, 3) array
        First measurement.
    step_s : float
        Time between two calls [s].
    """

    def __init__(self, gains: Sequence[LadrcGains], poses: FloatArray, step_s: float) -> None:
        self._stiffness = np.array([one.stiffness for one in gains])
        self._damping = np.array([one.damping for one in gains])
        self._lead = np.array([one.thruster_lead for one in gains])
        self._free = _Observer(gains, step_s, 0.0)
        self._docked = _Observer(gains, step_s, DOCKED_LEAK)
        self._states = np.zeros((len(poses), AXES, 3))
        self._states[:, :, 0] = poses
        self._acceleration = np.zeros((len(poses), AXES))

    @property
    def disturbance(self) -> FloatArray:
        """Estimated acceleration by all that is not thrust (n, 3) [m/s^2], [rad/s^2]."""
        return self._states[:, :, 2]

    def command(self, measured: FloatArray, reference: Reference, docked: BoolArray) -> FloatArray:
        """Return the acceleration to make; see `PoseController.command`."""
        self._observe(measured, docked)
        z1, z2, z3 = np.moveaxis(self._states, 2, 0)
        wanted = self._stiffness * pose_error(reference.poses, z1) + self._damping * (reference.velocities - z2)
        asked = wanted + reference.accelerations - z3
        return np.asarray(self._acceleration + self._lead * (asked - self._acceleration))

    def applied(self, accelerations: FloatArray, is_cut: BoolArray) -> None:
        """Feed the observer what is really done, so that a limit is not taken for a disturbance."""
        del is_cut
        self._acceleration = accelerations

    def _observe(self, measured: FloatArray, docked: BoolArray) -> None:
        poses = self._states[:, :, 0]
        near = poses + pose_error(measured, poses)  # the measured heading, in the turn of the estimate
        inputs = np.stack([near, self._acceleration], axis=2)
        states = self._free.advance(self._states, inputs)
        if docked.any():
            states = np.where(docked[:, None, None], self._docked.advance(self._states, inputs), states)
        self._states = states


class _Observer:
    """Sampled observers of all boats."""

    def __init__(self, gains: Sequence[LadrcGains], step_s: float, leak: float) -> None:
        sampled = [observer_matrices(one, step_s, leak) for one in gains]
        self._transition = np.stack([transition for transition, _ in sampled])
        self._response = np.stack([response for _, response in sampled])

    def advance(self, states: FloatArray, inputs: FloatArray) -> FloatArray:
        """Return the states (n, 3, 3) after a step with inputs (n, 3, 2)."""
        moved = self._transition @ states[..., None] + self._response @ inputs[..., None]
        return np.asarray(moved[..., 0])
