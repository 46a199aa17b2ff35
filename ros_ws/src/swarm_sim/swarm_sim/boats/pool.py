"""Boats in a pool: bodies, firmware, magnets, wind and waves, from control step to control step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from importlib import import_module

import numpy as np

from swarm_msgs_py.assembly.faces import Face, Gender, Layout
from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.boats.bodies import Bodies, Latch
from swarm_sim.boats.config import BoatsConfig
from swarm_sim.boats.firmware import Firmware, PoseSensor
from swarm_sim.boats.hulls import overlapping_hulls
from swarm_sim.boats.magnets import Magnets
from swarm_sim.boats.planar_bodies import PlanarBodies
from swarm_sim.boats.pose_control import Reference
from swarm_sim.boats.water import Water

CONTACT_M = 0.002
"""Hulls that overlap by less only touch; a rigid-body engine lets them, for a moment [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Fleet:
    """The boats of a pool.

    Attributes
    ----------
    poses : (n, 3) array
        At the start, world frame.
    layouts : sequence of Layout
        Mechanisms of each boat in its own frame.
    gender : Gender
    """

    poses: FloatArray
    layouts: Sequence[Layout]
    gender: Gender


class BodyKind(Enum):
    """Who moves the bodies."""

    PLANAR = "planar"
    BULLET = "bullet"


@dataclass(frozen=True, slots=True)
class LatchEvent:
    """Two sides began or ceased to hold each other.

    Attributes
    ----------
    time_s : float
    latch : Latch
    holds : bool
    """

    time_s: float
    latch: Latch
    holds: bool


def make_bodies(kind: BodyKind, config: BoatsConfig, poses: FloatArray) -> Bodies:
    """Return the bodies of a back end.

    Raises
    ------
    PhysicsError
        If the back end is not installed or does not start.
    """
    if kind is BodyKind.PLANAR:
        return PlanarBodies(config.hull, poses, 1.0 / config.control_hz)
    try:
        # Imported on demand: the other back end must work where this one is not installed.
        module = import_module("swarm_sim.world.pybullet_boats")
    except ImportError as error:
        raise PhysicsError(
            f"physics back end 'bullet' is not installed ({error}); install pybullet or use the planar one"
        ) from error
    bodies: Bodies = module.BulletBoats(config, poses)
    return bodies


class Pool:
    """All boats of a run.

    Parameters
    ----------
    config : BoatsConfig
    kind : BodyKind
    fleet : Fleet
    seed : int
        Of wind, waves and noise.

    Attributes
    ----------
    time_s : float
    alive : (n,) bool array
        Whose computer works. The firmware of a boat without one holds its place, unless it is docked: then it lets
        itself be carried.
    measured : (n, 3) array
        Last measured poses.
    references : (n, 3) array
        Poses that the firmware holds now.
    events : list of LatchEvent
        In the order of time.
    overlaps : set of (int, int)
        Boats whose hulls ran into each other so far.
    """

    def __init__(self, config: BoatsConfig, kind: BodyKind, fleet: Fleet, seed: int) -> None:
        count = len(fleet.poses)
        self._step_s = 1.0 / config.control_hz
        self._side_m = config.hull.side_m
        self._sight_m = config.pose.sight_m
        self._sensor = PoseSensor(config.pose, [seed] * count, range(count))
        self._water = Water(config.water, [seed] * count, range(count), self._step_s)
        self._magnets = Magnets(config.magnets, fleet.layouts, fleet.gender)
        self._bodies = make_bodies(kind, config, fleet.poses)
        self.measured: FloatArray = self._sensor.measure(self._bodies.poses)
        self._firmware = Firmware(config, self.measured, self._step_s)
        self.references: FloatArray = np.array(fleet.poses, dtype=np.float64)
        self._ticks = 0
        self.time_s = 0.0
        self.alive: BoolArray = np.ones(count, dtype=np.bool_)
        self.events: list[LatchEvent] = []
        self.overlaps: set[tuple[int, int]] = set()

    @property
    def poses(self) -> FloatArray:
        """True poses (n, 3)."""
        return self._bodies.poses

    @property
    def velocities(self) -> FloatArray:
        """True velocities (n, 3)."""
        return self._bodies.velocities

    @property
    def contacts(self) -> BoolArray:
        """Which contact foils are pressed (n, 4)."""
        return self._magnets.contacts

    def seen_by(self, boat: int) -> FloatArray:
        """Return the measured places of the other hulls around a boat (k, 2) [m], ascending."""
        places = self.measured[:, :2]
        is_near = np.abs(places - places[boat]).max(axis=1) <= self._sight_m
        is_near[boat] = False
        near: FloatArray = places[is_near]
        order = np.lexsort(near.T[::-1])
        return np.asarray(near[order])

    @property
    def thrusts(self) -> FloatArray:
        """Force of each thruster (n, 4) [N]."""
        return self._firmware.thrusts

    @property
    def latches(self) -> tuple[Latch, ...]:
        """Pairs of sides that hold each other."""
        return tuple(self._magnets.latches)

    def advance(self, velocities: FloatArray, duration_s: float) -> None:
        """Run all boats while their references move steadily.

        Parameters
        ----------
        velocities : (n, 3) array
            Of the references, world frame [m/s], [rad/s].
        duration_s : float
            Rounded to whole control steps.
        """
        self._magnets.look_around(self._bodies.poses)
        velocities = np.where(self.alive[:, None], velocities, 0.0)
        still = np.zeros_like(velocities)
        docked = self._magnets.is_docked
        for _ in range(round(duration_s / self._step_s)):
            here = self._bodies.poses
            self.measured = self._sensor.measure(here)
            self.references = self.references + self._step_s * velocities
            reference = Reference(self.references, velocities, still)
            push = self._firmware.wrenches(self.measured, reference, docked, self.alive | ~docked)
            push = push + self._water.wrenches(here) + self._magnets.wrenches(here)
            self._bodies.step(push)
            self._ticks += 1
            self.time_s = self._ticks * self._step_s
            if self._dock():
                docked = self._magnets.is_docked
        self.overlaps.update(overlapping_hulls(self._bodies.poses, self._side_m, CONTACT_M))

    def fail_magnet(self, boat: int, face: Face) -> None:
        """Switch a magnet off for good."""
        for latch in self._magnets.fail(boat, face):
            self._bodies.release(latch)
            self.events.append(LatchEvent(self.time_s, latch, holds=False))

    def close(self) -> None:
        """Free what the back end holds; may be called again."""
        self._bodies.close()

    def _dock(self) -> bool:
        """Note what latched or was torn in the last step; return whether anything did."""
        torn, fresh = self._bodies.torn(), self._magnets.latch(self._bodies.poses)
        for latch in torn:
            self._magnets.drop(latch)
            self.events.append(LatchEvent(self.time_s, latch, holds=False))
        for latch in fresh:
            self._bodies.latch(latch)
            self.events.append(LatchEvent(self.time_s, latch, holds=True))
        return bool(torn or fresh)
