"""The world of assembling boats: a pool and radios, one tick at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from swarm_msgs_py.assembly.boat_io import AssemblyInputs
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.types import MISSION, BoolArray, FloatArray, NodeId
from swarm_sim.boats.config import BoatsConfig
from swarm_sim.boats.pool import BodyKind, Fleet, LatchEvent, Pool
from swarm_sim.commanded_world import CommandedWorld
from swarm_sim.config import RadioConfig
from swarm_sim.electronics import Electronics
from swarm_sim.radio.links import make_links
from swarm_sim.radio.medium import RadioTraffic
from swarm_sim.world.obstacles import ObstacleField


@dataclass(frozen=True, slots=True, kw_only=True)
class BoatSimConfig(Config):
    """All settings of the world of boats."""

    period_s: float = setting(0.25, "control period: one tick", unit="s", minimum=0.05, maximum=1.0)
    bodies: BodyKind = setting(BodyKind.BULLET, "bullet: floating bodies with contacts; planar: fast, without contacts")
    boats: BoatsConfig = section(BoatsConfig, "hull, thrusters, magnets, water, firmware")
    radio: RadioConfig = section(RadioConfig, "radio medium")


@dataclass(frozen=True, slots=True, eq=False)
class PoolScene:
    """What a run of boats starts with.

    Attributes
    ----------
    fleet : Fleet
    antenna : (2,) array
        Where the mission computer's radio is [m].
    magnets : mapping of (NodeId, Face) to int
        Tick in which the magnet on a side fails, for those that are to fail.
    """

    fleet: Fleet
    antenna: FloatArray
    magnets: Mapping[tuple[NodeId, Face], int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class PoolTruth:
    """What is true in a tick; rows in the order of `BoatSimulation.robots`.

    Attributes
    ----------
    tick : int
    time : float
        Of the start of the tick [s].
    positions, ends : (n, 2) array
        At the start and at the end of the tick [m].
    yaws : (n,) array
        At its start [rad].
    alive : (n,) bool array
    events : tuple of LatchEvent
        What latched or came apart in the tick.
    overlaps : frozenset of (int, int)
        Boats whose hulls have run into each other so far.
    energy_n2s : float
        Squared thrust of all boats at the end of the tick, times its duration [N^2 s].
    radio : RadioTraffic
    """

    tick: int
    time: float
    positions: FloatArray
    ends: FloatArray
    yaws: FloatArray
    alive: BoolArray
    events: tuple[LatchEvent, ...]
    overlaps: frozenset[tuple[int, int]]
    energy_n2s: float
    radio: RadioTraffic


class BoatSimulation(CommandedWorld[AssemblyInputs]):
    """The world of one run of boats; implements `swarm_sim.ticked_world.TickedWorld`.

    Parameters
    ----------
    config : BoatSimConfig
    scene : PoolScene
    seed : int
        Seed of the run.
    deaths : mapping of NodeId to int, optional
        The tick from which on the computer of a boat is dead, for those that are to die. Its hull, magnets and firmware
        stay.
    """

    def __init__(
        self, config: BoatSimConfig, scene: PoolScene, seed: int, deaths: Mapping[NodeId, int] = MappingProxyType({})
    ) -> None:
        count = len(scene.fleet.poses)
        links = make_links(config.radio, ObstacleField(()))
        nodes = (*map(NodeId, range(count)), MISSION)
        super().__init__(Electronics(config.radio, links, nodes, config.period_s, seed, deaths), count, config.period_s)
        self._side_m = config.boats.hull.side_m
        self._antenna = np.array(scene.antenna, dtype=np.float64)[None]
        self._magnets = dict(scene.magnets)
        self._pool = Pool(config.boats, config.bodies, scene.fleet, seed)

    @property
    def events(self) -> tuple[LatchEvent, ...]:
        """All that latched or came apart so far."""
        return tuple(self._pool.events)

    def advance(self) -> PoolTruth:
        """Move the boats by one tick, and begin the next."""
        pool, alive = self._pool, self._working()
        for (robot, face), tick in list(self._magnets.items()):
            if tick <= self._tick:
                pool.fail_magnet(robot, face)
                del self._magnets[robot, face]
        pool.alive = alive
        starts, known = pool.poses, len(pool.events)
        pool.advance(self._velocities, self._period_s)
        truth = PoolTruth(
            tick=self._tick,
            time=self.time,
            positions=starts[:, :2],
            ends=pool.poses[:, :2],
            yaws=starts[:, 2],
            alive=alive,
            events=tuple(pool.events[known:]),
            overlaps=frozenset(pool.overlaps),
            energy_n2s=float((pool.thrusts**2).sum()) * self._period_s,
            radio=self._electronics.traffic,
        )
        self._begin_tick()
        return truth

    @property
    def radii(self) -> FloatArray:
        """How large robots are drawn, (n,) [m]."""
        return np.full(len(self.robots), self._side_m / 2.0)

    def close(self) -> None:
        """Free the physics back end; may be called again."""
        self._pool.close()

    @property
    def _antennas(self) -> FloatArray:
        return np.concatenate([self._pool.poses[:, :2], self._antenna])

    def _sense(self) -> Mapping[NodeId, AssemblyInputs]:
        pool, electronics = self._pool, self._electronics
        contacts = pool.contacts
        return {
            robot: AssemblyInputs(
                tick=self._tick,
                time=self.time,
                pose=pool.measured[robot].copy(),
                reference=pool.references[robot].copy(),
                contacts=frozenset(face for face in Face if contacts[robot, face]),
                inbox=electronics.inboxes[robot],
                seen=pool.seen_by(robot),
            )
            for robot in self.robots
            if electronics.is_alive(robot)
        }
