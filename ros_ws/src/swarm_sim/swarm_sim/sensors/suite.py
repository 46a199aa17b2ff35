"""All sensors of all robots, wired once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import SimConfig
from swarm_sim.radio.links import LinkTable
from swarm_sim.scene import Scene
from swarm_sim.sensors.fix import PositionSensor
from swarm_sim.sensors.imu import Imu
from swarm_sim.sensors.proximity import Proximity
from swarm_sim.sensors.ranging import Ranging
from swarm_sim.world.obstacles import ObstacleField
from swarm_sim.world.world import BodyState

Reading = tuple[ImuSample, PositionFix | None, RangeScan, FloatArray]
"""One robot's inertial sample, fix, range scan and proximity points."""


class SensorSuite:
    """Measures everything for everybody once per tick.

    Each sensor draws for all robots, also dead ones, from a stream named after itself and the tick: no sensor, robot or
    death shifts the noise of another, and asking twice gives the same answer.
    """

    def __init__(self, config: SimConfig, scene: Scene, obstacles: ObstacleField, seed: int) -> None:
        robots = scene.robots
        self._imu = Imu(config.imu, len(robots), seed)
        self._fix = PositionSensor(config.fix, np.array([robot.has_position_sensor for robot in robots]), seed)
        ids = np.array([robot.id for robot in robots], dtype=np.int64)
        self._ranging = Ranging(config.ranging, ids, config.period_s, seed)
        radii = np.array([robot.type.coverage_radius_m for robot in robots])
        self._proximity = Proximity(config.proximity, radii, obstacles, seed)

    def measure(
        self, tick: int, bodies: BodyState, mean_accelerations: FloatArray, links: LinkTable
    ) -> Iterator[Reading]:
        """Yield one reading per robot, in the scene's order.

        Parameters
        ----------
        tick : int
        bodies : BodyState
            True state now.
        mean_accelerations : (n, 2) array
            Over the tick that ended, world frame [m/s^2].
        links : LinkTable
            Radio links now, robots first.
        """
        return zip(
            self._imu.measure(tick, bodies, mean_accelerations),
            self._fix.measure(tick, bodies.positions),
            self._ranging.measure(tick, bodies.positions, links),
            self._proximity.measure(tick, bodies),
            strict=True,
        )
