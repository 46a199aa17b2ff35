"""What runs on every boat at the control rate: pose sensor, controller, thruster allocation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.boats.config import BoatsConfig, ControllerKind, PoseSensorConfig
from swarm_sim.boats.gains import LADRC_GAINS, PID_GAINS, ZIEGLER_NICHOLS_GAINS
from swarm_sim.boats.ladrc import PAPER_GAINS, Ladrc
from swarm_sim.boats.pose_control import PoseController, Reference
from swarm_sim.boats.pose_pid import PosePid
from swarm_sim.boats.thrusters import Thrusters, feasible
from swarm_sim.boats.water import NoiseBlocks


class PoseSensor:
    """Motion capture of every boat.

    Parameters
    ----------
    config : PoseSensorConfig
    pools, boats : sequence of int
        Seed of the run of each boat, and its number: they name its noise.
    """

    def __init__(self, config: PoseSensorConfig, pools: Sequence[int], boats: Sequence[int]) -> None:
        self._sigma = np.array([config.sigma_m, config.sigma_m, np.radians(config.yaw_sigma_deg)])
        self._noise = NoiseBlocks([rng_for(p, "pose", b) for p, b in zip(pools, boats, strict=True)], 3)

    def measure(self, poses: FloatArray) -> FloatArray:
        """Return measured poses (n, 3)."""
        return poses + self._sigma * self._noise.draw()


class Firmware:
    """Holds poses with thrusters.

    Parameters
    ----------
    config : BoatsConfig
    poses : (n, 3) array
        Measured at the start.
    step_s : float
        Control step [s].
    controller : PoseController, optional
        Instead of the configured one.
    """

    def __init__(
        self, config: BoatsConfig, poses: FloatArray, step_s: float, controller: PoseController | None = None
    ) -> None:
        hull = config.hull
        self._limits = config.thrusters
        self._masses = np.array([hull.mass_kg, hull.mass_kg, hull.inertia_kgm2])
        self._controller = controller or make_controller(config.controller, poses, step_s)
        self._thrusters = Thrusters(config.thrusters, len(poses), step_s)
        self._expected = Thrusters(config.thrusters, len(poses), step_s)  # the firmware's own model of them

    @property
    def thrusts(self) -> FloatArray:
        """Force of each thruster (n, 4) [N]."""
        return self._thrusters.thrusts

    def wrenches(self, measured: FloatArray, reference: Reference, docked: BoolArray, powered: BoolArray) -> FloatArray:
        """Return what the thrusters do in the next step, world frame (n, 3) [N], [N m].

        Parameters
        ----------
        measured : (n, 3) array
        reference : Reference
        docked, powered : (n,) bool array
            Who is held by another boat; whose thrusters have power.
        """
        turn = np.exp(1j * measured[:, 2])
        asked = self._masses * self._controller.command(measured, reference, docked)
        asked = _rotated(asked, turn.conj())
        asked[~powered] = 0.0
        can = feasible(asked, self._limits)
        is_cut = np.asarray((np.abs(can - asked) > 1e-9).any(axis=1))
        self._controller.applied(_rotated(self._expected.drive(can), turn) / self._masses, is_cut)
        return _rotated(self._thrusters.drive(can), turn)


def make_controller(kind: ControllerKind, poses: FloatArray, step_s: float) -> PoseController:
    """Return a controller of the configured kind.

    Parameters
    ----------
    kind : ControllerKind
    poses : (n, 3) array
        First measurement.
    step_s : float
        Time between two calls [s].
    """
    if kind is ControllerKind.LADRC:
        return Ladrc([LADRC_GAINS], poses, step_s)
    if kind is ControllerKind.LADRC_PAPER:
        return Ladrc([PAPER_GAINS], poses, step_s)
    return PosePid([PID_GAINS if kind is ControllerKind.PID else ZIEGLER_NICHOLS_GAINS], poses, step_s)


def _rotated(wrenches: FloatArray, turn: np.ndarray[tuple[int, ...], np.dtype[np.complex128]]) -> FloatArray:
    """Return forces (n, 2 of 3) turned by unit complex numbers (n,), with the same yaw moments."""
    forces = (wrenches[:, 0] + 1j * wrenches[:, 1]) * turn
    return np.column_stack([forces.real, forces.imag, wrenches[:, 2]])
