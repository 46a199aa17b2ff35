"""Boats in the plane, docked groups as rigid bodies; vectorized, without contacts between hulls.

Fossen's equations in the plane, with equal surge and sway mass, are Newton's in the world frame: the Coriolis terms of
the body frame (paper, eq. (6)) are what turning with the boat looks like. Drag and force of a step have an exact
solution. The velocities of a docked group are then replaced by the rigid motion of the same momentum and angular
momentum, and its boats drawn to their places in the best-fitting rigid shape (M. Mueller et al., "Meshless deformations
based on shape matching", 2005), which changes neither.
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import BoolArray, FloatArray, IntArray
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import HullConfig
from swarm_sim.boats.pose_control import YAW, pose_error

ALIGNING_S = 0.15
"""Time constant with which latched boats are drawn into line [s]."""


class PlanarBodies:
    """Implements `Bodies`.

    Parameters
    ----------
    config : HullConfig
    poses : (n, 3) array
        At the start.
    step_s : float
        Control step [s].
    """

    def __init__(self, config: HullConfig, poses: FloatArray, step_s: float) -> None:
        self.poses = np.array(poses, dtype=np.float64)
        self.velocities = np.zeros_like(self.poses)
        self._mass, self._inertia = config.mass_kg, config.inertia_kgm2
        masses = np.array([config.mass_kg, config.mass_kg, config.inertia_kgm2])
        rates = np.array([config.drag_nspm, config.drag_nspm, config.yaw_drag_nms]) / masses
        self._decay = np.exp(-rates * step_s)
        self._gain = -np.expm1(-rates * step_s) / (rates * masses)
        self._step_s = step_s
        self._latches: list[Latch] = []
        self._shape = _GroupShape(len(poses), [])

    def step(self, wrenches: FloatArray) -> None:
        """Advance by one control step; see `Bodies.step`."""
        self.velocities = self._decay * self.velocities + self._gain * wrenches
        if self._latches:
            self._make_rigid()
        self.poses = self.poses + self._step_s * self.velocities
        if self._latches:
            self._align()

    def latch(self, latch: Latch) -> None:
        """Hold two boats together; see `Bodies.latch`."""
        self._latches.append(latch)
        self._shape = _GroupShape(len(self.poses), self._latches)

    def release(self, latch: Latch) -> None:
        """Let two boats go; see `Bodies.release`."""
        self._latches.remove(latch)
        self._shape = _GroupShape(len(self.poses), self._latches)

    def torn(self) -> list[Latch]:
        """Return none: thrusters are a hundred times weaker than magnets."""
        return []

    def close(self) -> None:
        """Do nothing: there is nothing to free."""

    def _make_rigid(self) -> None:
        shape = self._shape
        arms = self.poses[:, :2] - shape.means(self.poses[:, :2])
        drift = shape.means(self.velocities[:, :2])
        spin = _cross(arms, self.velocities[:, :2]) * self._mass + self._inertia * self.velocities[:, YAW]
        inertia = (arms**2).sum(axis=1) * self._mass + self._inertia
        rate = shape.means(spin) / shape.means(inertia)
        rigid = np.column_stack([drift[:, 0] - rate * arms[:, 1], drift[:, 1] + rate * arms[:, 0], rate])
        self.velocities = np.where(shape.is_docked[:, None], rigid, self.velocities)

    def _align(self) -> None:
        shape = self._shape
        centers = shape.means(self.poses[:, :2])
        arms, slots = self.poses[:, :2] - centers, shape.slots
        # Best rotation of the slots onto the boats, with the headings as further evidence.
        turn = pose_error(self.poses, np.zeros_like(self.poses))[:, YAW] - shape.turns
        sine = _cross(slots, arms) * self._mass + self._inertia * np.sin(turn)
        cosine = (slots * arms).sum(axis=1) * self._mass + self._inertia * np.cos(turn)
        angle = np.arctan2(shape.means(sine), shape.means(cosine))
        cos, sin = np.cos(angle), np.sin(angle)
        places = np.column_stack([cos * slots[:, 0] - sin * slots[:, 1], sin * slots[:, 0] + cos * slots[:, 1]])
        wanted = np.column_stack([centers + places, angle + shape.turns])
        share = np.where(shape.is_docked, -np.expm1(-self._step_s / ALIGNING_S), 0.0)
        self.poses = self.poses + share[:, None] * pose_error(wanted, self.poses)


class _GroupShape:
    """Who is docked with whom, and where everybody belongs in its group.

    Attributes
    ----------
    is_docked : (n,) bool array
    slots : (n, 2) array
        Place of each boat relative to the center of its group, in a frame of the group [m].
    turns : (n,) array
        Heading of each boat in that frame [rad].
    """

    def __init__(self, count: int, latches: list[Latch]) -> None:
        self._labels: IntArray = np.arange(count, dtype=np.int64)
        self.slots: FloatArray = np.zeros((count, 2))
        self.turns: FloatArray = np.zeros(count)
        links: dict[int, list[tuple[int, FloatArray, float]]] = {}
        for one in latches:
            back = -one.turn
            links.setdefault(one.boat, []).append((one.other, one.offset, one.turn))
            links.setdefault(one.other, []).append((one.boat, -_turned(one.offset, back), back))
        self.is_docked: BoolArray = np.isin(self._labels, list(links))
        seen: set[int] = set()
        for root in sorted(links):
            if root in seen:
                continue
            seen.add(root)
            border = [root]
            while border:
                boat = border.pop()
                for other, offset, turn in links[boat]:
                    if other not in seen:
                        seen.add(other)
                        border.append(other)
                        self._labels[other] = root
                        self.slots[other] = self.slots[boat] + _turned(offset, self.turns[boat])
                        self.turns[other] = self.turns[boat] + turn
        self._sizes = np.bincount(self._labels, minlength=count).astype(np.float64)
        self.slots -= self.means(self.slots)

    def means(self, values: FloatArray) -> FloatArray:
        """Return for each boat the mean of values (n,) or (n, 2) over its group."""
        if values.ndim == 1:
            sums = np.bincount(self._labels, values, len(self._labels)).astype(np.float64)
            return np.asarray(sums[self._labels] / self._sizes[self._labels])
        return np.column_stack([self.means(column) for column in values.T])


def _cross(one: FloatArray, other: FloatArray) -> FloatArray:
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]


def _turned(vector: FloatArray, angle: float) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])
