"""Point robots in space: a speed limit, noise per step, links and sight by range and obstacles; no bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import MISSION, BoolArray, FloatArray, NodeId
from swarm_sim.commanded_world import CommandedWorld
from swarm_sim.electronics import Electronics
from swarm_sim.points.config import PointSimConfig
from swarm_sim.points.links import SpaceLinks
from swarm_sim.radio.medium import RadioTraffic

NO_SPEED = 1e-12  # [m/s]
SHOWN_RADIUS_M = 0.25  # of robots that are points, for viewers


@dataclass(frozen=True, slots=True, eq=False)
class PointTruth:
    """What is true in a tick; rows in the order of `PointSimulation.robots`.

    Attributes
    ----------
    tick : int
    time : float
        Of the start of the tick [s].
    positions, ends : (n, 3) array
        At the start and at the end of the tick [m].
    yaws : (n,) array
        Points have no heading: zeros.
    alive : (n,) bool array
    links : (l, 2) int array
        Rows of the pairs of live robots that hear each other at the start of the tick.
    radio : RadioTraffic
    """

    tick: int
    time: float
    positions: FloatArray
    ends: FloatArray
    yaws: FloatArray
    alive: BoolArray
    links: np.ndarray
    radio: RadioTraffic


@dataclass(frozen=True, slots=True, eq=False)
class PointScene:
    """What a run of point robots starts with.

    Attributes
    ----------
    starts : (n, 3) array
        Where robots 0 to n - 1 start [m].
    leader : NodeId
        The only robot that is told where it is (assumption A4).
    antenna : (3,) array
        Where the mission computer's radio is [m].
    barriers : Barriers
    arrivals : mapping of NodeId to int
        Tick in which a robot appears where it starts, for those that are not there from the start.
    """

    starts: FloatArray
    leader: NodeId
    antenna: FloatArray
    barriers: Barriers = OPEN_SPACE
    arrivals: Mapping[NodeId, int] = field(default_factory=dict)


class PointSimulation(CommandedWorld[CoverageInputs]):
    """The world of one run of point robots; implements `swarm_sim.ticked_world.TickedWorld`.

    Parameters
    ----------
    config : PointSimConfig
    scene : PointScene
    seed : int
        Seed of the run.
    deaths : mapping of NodeId to int, optional
        The tick from which on a node is dead, for those that are to die. Dead robots are gone: nobody senses them.
    """

    def __init__(
        self,
        config: PointSimConfig,
        scene: PointScene,
        seed: int,
        deaths: Mapping[NodeId, int] = MappingProxyType({}),
    ) -> None:
        count = len(scene.starts)
        links = SpaceLinks(config.radio, scene.barriers)
        nodes = (*map(NodeId, range(count)), MISSION)
        electronics = Electronics(config.radio, links, nodes, config.period_s, seed, deaths, scene.arrivals)
        super().__init__(electronics, count, config.period_s)
        self._config, self._leader, self._barriers = config, scene.leader, scene.barriers
        self._positions: FloatArray = np.array(scene.starts, dtype=np.float64)
        self._antenna = np.array(scene.antenna, dtype=np.float64)[None]
        self._process = rng_for(seed, "points", "process noise")
        self._sensing = rng_for(seed, "points", "offsets")

    @property
    def positions(self) -> FloatArray:
        """Where the robots are now, (n, 3) [m]."""
        return self._positions

    def advance(self) -> PointTruth:
        """Move the robots by one tick, and begin the next."""
        alive = self._working()
        starts, table = self._positions, self._electronics.links(self._antennas)
        self._positions = starts + self._steps(alive)
        truth = PointTruth(
            tick=self._tick,
            time=self.time,
            positions=starts,
            ends=self._positions,
            yaws=np.zeros(len(starts)),
            alive=alive,
            links=np.argwhere(np.triu(table.connected[:-1, :-1])),
            radio=self._electronics.traffic,
        )
        self._begin_tick()
        return truth

    @property
    def radii(self) -> FloatArray:
        """How large robots are drawn, (n,) [m]."""
        return np.full(len(self.robots), SHOWN_RADIUS_M)

    def close(self) -> None:
        """Nothing is held."""

    @property
    def _antennas(self) -> FloatArray:
        return np.concatenate([self._positions, self._antenna])

    def _steps(self, alive: BoolArray) -> FloatArray:
        """Return how far each robot moves in this tick, (n, 3) [m] (eqs. (5) and (10))."""
        speeds = np.linalg.norm(self._velocities, axis=1, keepdims=True)
        limit = np.minimum(1.0, self._config.speed_mps / np.maximum(speeds, NO_SPEED))
        steps: FloatArray = self._velocities * (self._config.period_s * limit)
        noise = self._config.process_sigma_m * self._process.normal(size=steps.shape)
        is_shaken = speeds[:, 0] > 0.0 if not self._config.drifts else np.ones(len(steps), dtype=np.bool_)
        steps[is_shaken] += noise[is_shaken]
        steps[~alive] = 0.0
        if self._barriers:
            steps[self._barriers.cut(self._positions, self._positions + steps)] = 0.0
        return steps

    def _sense(self) -> Mapping[NodeId, CoverageInputs]:
        electronics, alive = self._electronics, self._electronics.alive[:-1]
        distances = electronics.links(self._antennas).distances[:-1, :-1]
        seen = (distances < self._config.sight_m) & alive & alive[:, None]
        np.fill_diagonal(seen, val=False)
        first, second = np.nonzero(seen)
        if self._barriers:
            is_free = ~self._barriers.cut(self._positions[first], self._positions[second])
            first, second = first[is_free], second[is_free]
        offsets = self._positions[second] - self._positions[first]
        if self._config.offset_sigma_m > 0.0:
            offsets += self._config.offset_sigma_m * self._sensing.normal(size=offsets.shape)
        cuts = np.searchsorted(first, np.arange(len(alive) + 1))
        return {
            robot: CoverageInputs(
                tick=self._tick,
                time=self.time,
                ids=second[cuts[robot] : cuts[robot + 1]],
                offsets=offsets[cuts[robot] : cuts[robot + 1]],
                position=self._positions[robot].copy() if robot == self._leader else None,
                inbox=electronics.inboxes[robot],
            )
            for robot in self.robots
            if alive[robot]
        }
