"""The simulated world: true bodies in, sensor readings and radio frames out, one tick at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.messages.camera import CameraInfo
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.step_io import AgentInputs, MissionInputs
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.camera.feed import CameraFeed
from swarm_sim.config import SimConfig
from swarm_sim.electronics import Electronics
from swarm_sim.radio.links import LinkTable, make_links
from swarm_sim.radio.medium import RadioTraffic
from swarm_sim.scene import RobotSpec, Scene, check_scene
from swarm_sim.sensors.suite import SensorSuite
from swarm_sim.ticked_world import Observation
from swarm_sim.world.clearance import clearance
from swarm_sim.world.obstacles import ObstacleField
from swarm_sim.world.registry import make_world

__all__ = ["Observation", "RadioTraffic", "RobotSpec", "Scene", "Simulation", "TickTruth"]


@dataclass(frozen=True, slots=True, eq=False)
class TickTruth:
    """What truly happened in the tick that just ran; rows in the order of `Simulation.robots`.

    Attributes
    ----------
    tick : int
    time : float
        Of the start of the tick [s].
    positions, velocities : (n, 2) array
        At the start of the tick, world frame [m], [m/s].
    yaws, heights : (n,) array
        At the start of the tick [rad], [m].
    alive : (n,) bool array
        Whose electronics worked during the tick.
    samples, sample_velocities : (m, n, 2) array
        Evenly spread over the tick at 20 Hz or more, the last at its end [m], [m/s].
    min_clearance : float
        Smallest free gap between two coverage circles, or a circle and an obstacle, at the start and at the samples
        [m]; negative where they overlap, infinite for a single robot without obstacles.
    overlaps : tuple of (int, int)
        Ids of robots that overlapped during the tick, ascending; obstacle k is -1 - k, after the robot.
    radio : RadioTraffic
    """

    tick: int
    time: float
    positions: FloatArray
    yaws: FloatArray
    velocities: FloatArray
    heights: FloatArray
    alive: NDArray[np.bool_]
    samples: FloatArray
    sample_velocities: FloatArray
    min_clearance: float
    overlaps: tuple[tuple[int, int], ...]
    radio: RadioTraffic


class Simulation:
    """The world of one run. A tick is ``observe``, ``apply``, ``advance``.

    Parameters
    ----------
    config : SimConfig
    scene : Scene
    seed : int
        Seed of the run; equal config, scene, seed and commands give equal results, byte for byte.
    deaths : mapping of NodeId to int, optional
        The tick from which on the electronics of a robot, or of `MISSION`, are dead, as `kill` makes them, for those
        that are to die.
    arrivals : mapping of NodeId to int, optional
        The tick from which on a robot is switched on, for those that come later; off before, or since its death.

    Raises
    ------
    ConfigError
        If the scene cannot be started from, or the settings do not fit together.
    PhysicsError
        If the back end is not installed or refuses the scene.
    """

    def __init__(
        self,
        config: SimConfig,
        scene: Scene,
        seed: int,
        deaths: Mapping[NodeId, int] = MappingProxyType({}),
        arrivals: Mapping[NodeId, int] = MappingProxyType({}),
    ) -> None:
        check_scene(scene)
        self.robots: tuple[NodeId, ...] = tuple(robot.id for robot in scene.robots)
        self._period_s = config.period_s
        self._radii = np.array([robot.type.coverage_radius_m for robot in scene.robots])
        self._antenna = np.array([scene.mission_position], dtype=np.float64)
        self._obstacles = ObstacleField(scene.obstacles)
        links = make_links(config.radio, self._obstacles)
        nodes = (*self.robots, MISSION)
        self._electronics = Electronics(config.radio, links, nodes, config.period_s, seed, deaths, arrivals)
        self._sensors = SensorSuite(config, scene, self._obstacles, seed)
        self._world = make_world(config, scene, seed)
        self._camera = CameraFeed(config.camera, scene.markers, seed, config.renderer) if config.camera.is_on else None

        self._tick = 0
        self._setpoints = np.zeros((len(self.robots), 3))
        self._patience = int(config.servo.command_hold_s / config.period_s + 1e-9)
        self._unanswered = np.zeros(len(self.robots), dtype=np.int64)
        self._mean_accelerations = np.zeros((len(self.robots), 2))
        self._observed: Mapping[NodeId, AgentInputs] | None = None
        self._is_applied = False

    @property
    def camera_info(self) -> CameraInfo | None:
        """Return what the maker of the overhead camera says of it; None if there is none."""
        return None if self._camera is None else self._camera.info

    @property
    def tick(self) -> int:
        """Return the number of the current tick, 0, 1, ..."""
        return self._tick

    @property
    def time(self) -> float:
        """Return the simulated time at the start of the current tick [s]."""
        return self._tick * self._period_s

    def observe(self, shape: FloatArray | None = None) -> Observation[AgentInputs]:
        """Return what every actor learns in this tick; the same however often it is asked.

        Parameters
        ----------
        shape : (k, 2) array or None
            Contour that the operator orders in this tick [m].
        """
        if self._observed is None:
            self._observed = self._sense()
        image, info = None, None
        if self._camera is not None:
            image, info = self._camera.image(self.time, self._world.state), self.camera_info
        mission = MissionInputs(self._tick, self.time, self._electronics.inboxes[-1], shape, image, info)
        return Observation(self._tick, self.time, self._observed, mission)

    def apply(self, commands: Mapping[NodeId, VelocityCommand], outboxes: Mapping[NodeId, tuple[bytes, ...]]) -> None:
        """Hand over what the actors answered in this tick; at most once per tick.

        A live robot without an answer keeps its last command for `servo.command_hold_s` more, then it stops. What comes
        from a dead node is ignored.

        Parameters
        ----------
        commands : mapping of NodeId to VelocityCommand
        outboxes : mapping of NodeId to tuple of bytes
            Frames of robots and of `MISSION`.

        Raises
        ------
        KeyError
            If an address is not in the scene.
        RuntimeError
            If called twice in a tick.
        """
        if self._is_applied:
            raise RuntimeError(f"tick {self._tick}: the answers were applied already")
        self._is_applied = True
        self._unanswered += 1
        for robot, command in commands.items():
            if self._electronics.is_alive(robot):
                row = self._electronics.row[robot]
                self._setpoints[row] = command.forward, command.left, command.yaw_rate
                self._unanswered[row] = 0
        self._electronics.transmit(self._tick, outboxes, self._antennas)

    def advance(self) -> TickTruth:
        """Run the bodies through one control period, and begin the next tick."""
        if not self._is_applied:
            self.apply({}, {})
        self._setpoints[(self._unanswered > self._patience) | ~self._electronics.alive[:-1]] = 0.0
        motion = self._world.advance(self._setpoints)
        gap = clearance(motion.start.positions, motion.samples, self._radii, self._obstacles)
        robots = self.robots
        overlaps = [(int(robots[i]), int(robots[j])) for i, j in gap.robot_overlaps]
        overlaps += [(int(robots[i]), -1 - obstacle) for i, obstacle in gap.obstacle_overlaps]
        alive = self._electronics.alive[:-1].copy()
        alive.flags.writeable = False
        truth = TickTruth(
            tick=self._tick,
            time=self.time,
            positions=motion.start.positions,
            yaws=motion.start.yaws,
            velocities=motion.start.velocities,
            heights=motion.start.heights,
            alive=alive,
            samples=motion.samples,
            sample_velocities=motion.sample_velocities,
            min_clearance=gap.min_gap,
            overlaps=tuple(overlaps),
            radio=self._electronics.traffic,
        )
        self._begin_tick(motion.mean_accelerations)
        if self._camera is not None:
            # Now, and not when it is asked for: in real time, what is left of this tick is there to draw it.
            self._camera.image(self.time, self._world.state)
        return truth

    def kill(self, node: NodeId) -> None:
        """End a robot's electronics: no sensors, no radio, zero command; its body stays. Also for `MISSION`'s radio.

        Raises
        ------
        KeyError
            If the address is not in the scene.
        """
        if not self._electronics.kill(self._tick, node):
            return
        if self._observed is not None:
            self._observed = {robot: inputs for robot, inputs in self._observed.items() if robot != node}

    def revive(self, node: NodeId) -> None:
        """Switch a robot's electronics on, where its body stands; its sensors and its radio work from now on.

        Raises
        ------
        KeyError
            If the address is not in the scene.
        """
        if self._electronics.revive(self._tick, node):
            self._observed = None

    @property
    def radii(self) -> FloatArray:
        """Coverage radius of each robot, in the order of `robots` [m]."""
        return self._radii

    @property
    def links(self) -> tuple[tuple[int, int], ...]:
        """Rows of robots that can hear each other now, each pair once."""
        return self._current_links().pairs(len(self.robots))

    def is_on(self, node: NodeId) -> bool:
        """Return whether a robot's electronics, or the mission computer's, work."""
        return self._electronics.is_alive(node)

    def take_arrived(self) -> tuple[NodeId, ...]:
        """Return, once, the robots that were switched on because `arrivals` says so, in that order."""
        return self._electronics.take_arrived()

    def take_died(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that died because `deaths` says so, in the order of their deaths."""
        return self._electronics.take_died()

    def close(self) -> None:
        """Free the physics back end, and the camera's renderer; may be called again."""
        self._world.close()
        if self._camera is not None:
            self._camera.close()

    def _begin_tick(self, mean_accelerations: FloatArray) -> None:
        self._tick += 1
        self._mean_accelerations = mean_accelerations
        self._electronics.begin(self._tick)
        self._observed = None
        self._is_applied = False

    @property
    def _antennas(self) -> FloatArray:
        return np.concatenate([self._world.state.positions, self._antenna])

    def _current_links(self) -> LinkTable:
        return self._electronics.links(self._antennas)

    def _sense(self) -> Mapping[NodeId, AgentInputs]:
        readings = self._sensors.measure(self._tick, self._world.state, self._mean_accelerations, self._current_links())
        electronics = self._electronics
        return {
            robot: AgentInputs(self._tick, self.time, *reading, inbox=inbox)
            for robot, reading, inbox, is_alive in zip(
                self.robots, readings, electronics.inboxes[:-1], electronics.alive[:-1], strict=True
            )
            if is_alive
        }
