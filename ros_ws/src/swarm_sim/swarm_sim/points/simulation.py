"""Point robots in space: a speed limit, noise per step, links and sight by range and obstacles; no bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from swarm_msgs_py.coverage_io import CoverageInputs
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.messages.camera import CameraInfo
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import MISSION, BoolArray, FloatArray, NodeId
from swarm_sim.electronics import Electronics
from swarm_sim.points.config import PointSimConfig
from swarm_sim.points.links import SpaceLinks
from swarm_sim.radio.medium import RadioTraffic
from swarm_sim.ticked_world import Observation

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


class PointSimulation:
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
        self.robots = tuple(NodeId(robot) for robot in range(len(scene.starts)))
        self._config, self._leader, self._barriers = config, scene.leader, scene.barriers
        self._positions: FloatArray = np.array(scene.starts, dtype=np.float64)
        self._antenna = np.array(scene.antenna, dtype=np.float64)[None]
        links = SpaceLinks(config.radio, scene.barriers)
        nodes = (*self.robots, MISSION)
        self._electronics = Electronics(config.radio, links, nodes, config.period_s, seed, deaths, scene.arrivals)
        self._process = rng_for(seed, "points", "process noise")
        self._sensing = rng_for(seed, "points", "offsets")
        self._tick = 0
        self._velocities = np.zeros_like(self._positions)
        self._observed: Mapping[NodeId, CoverageInputs] | None = None
        self._is_applied = False

    @property
    def camera_info(self) -> CameraInfo | None:
        """Return None: nobody looks at these robots from above."""
        return None

    @property
    def tick(self) -> int:
        """Number of the current tick, 0, 1, ..."""
        return self._tick

    @property
    def time(self) -> float:
        """Simulated time at the start of the current tick [s]."""
        return self._tick * self._config.period_s

    @property
    def positions(self) -> FloatArray:
        """Where the robots are now, (n, 3) [m]."""
        return self._positions

    def observe(self) -> Observation[CoverageInputs]:
        """Return what every actor learns in this tick; the same however often it is asked."""
        if self._observed is None:
            self._observed = self._sense()
        mission = MissionInputs(self._tick, self.time, self._electronics.inboxes[-1])
        return Observation(self._tick, self.time, self._observed, mission)

    def apply(self, commands: Mapping[NodeId, FloatArray], outboxes: Mapping[NodeId, tuple[bytes, ...]]) -> None:
        """Hand over what the actors answered in this tick; at most once per tick. Who does not answer stands still.

        Raises
        ------
        KeyError
            If an address does not exist.
        RuntimeError
            If called twice in a tick.
        """
        if self._is_applied:
            raise RuntimeError(f"tick {self._tick}: the answers were applied already")
        self._is_applied = True
        for robot, velocity in commands.items():
            if self._electronics.is_alive(robot):
                self._velocities[robot] = velocity
        self._electronics.transmit(self._tick, outboxes, self._antennas)

    def advance(self) -> PointTruth:
        """Move the robots by one tick, and begin the next."""
        if not self._is_applied:
            self.apply({}, {})
        alive = self._electronics.alive[:-1].copy()
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
        self._tick += 1
        self._velocities = np.zeros_like(starts)
        self._electronics.begin(self._tick)
        self._observed, self._is_applied = None, False
        return truth

    def kill(self, node: NodeId) -> None:
        """End a robot, or the mission computer's radio; raises `KeyError` if it does not exist."""
        if self._electronics.kill(self._tick, node) and self._observed is not None:
            self._observed = {robot: inputs for robot, inputs in self._observed.items() if robot != node}

    def revive(self, node: NodeId) -> None:
        """Switch a robot on, where it stands; raises `KeyError` if it does not exist."""
        if self._electronics.revive(self._tick, node):
            self._observed = None

    def is_on(self, node: NodeId) -> bool:
        """Return whether a node works; raises `KeyError` if it does not exist."""
        return self._electronics.is_alive(node)

    @property
    def radii(self) -> FloatArray:
        """How large robots are drawn, (n,) [m]."""
        return np.full(len(self.robots), SHOWN_RADIUS_M)

    @property
    def links(self) -> tuple[tuple[int, int], ...]:
        """Pairs of robots that can hear each other now."""
        return self._electronics.links(self._antennas).pairs(len(self.robots))

    def take_arrived(self) -> tuple[NodeId, ...]:
        """Return, once, the robots that appeared because the scene says so."""
        return self._electronics.take_arrived()

    def take_died(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that died because `deaths` says so, in the order of their deaths."""
        return self._electronics.take_died()

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
