"""Rigid bodies with contacts on rough ground, by PyBullet.

Contact spheres roll freely: the ground has no Coulomb friction (Bullet multiplies the coefficients of two bodies), the
rolling resistance is the viscous force b v, and mu1 acts between hulls and walls (spec section 2, erratum E21).
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.types import FloatArray
from swarm_sim.bullet import open_server, pybullet
from swarm_sim.config import Ground, SimConfig
from swarm_sim.firmware.velocity_servo import wrap_angle
from swarm_sim.gravity import GRAVITY
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.world.chassis import Chassis
from swarm_sim.world.drives import make_drive
from swarm_sim.world.obstacles import convex_pieces
from swarm_sim.world.terrain import CELL_M, Terrain, make_terrain
from swarm_sim.world.world import BodyState, Motion, TickGrid, frozen, motion_between

WALL_HEIGHT_M = 1.5
"""Of walls above the highest ground."""
WALL_DEPTH_M = 1.0
"""Of walls below the deepest ground, so that no dip lets a robot under."""
FENCE_THICKNESS_M = 1.0
"""Walls around the outer edge of the ground: nobody falls off the world."""
SOLVER_ITERATIONS = 6
"""Enough for robots that stand on four points and touch a few others; more changes nothing measurable."""
SETTLING_S = 0.5
"""Time before tick 0 in which the bodies come to rest on the ground, held by their servos [s]."""
SINK_LIMIT_M = 1.0
"""A body this far below the deepest ground [m] has left it."""
ANGULAR_DAMPING = 0.04
"""Bullet's default, stated: takes the swing out of roll and pitch."""

ROBOT_GROUP, STATIC_GROUP = 1, 2
"""Collision filter bits: static bodies are compared with robots only."""
POSE_SIZE, VELOCITY_SIZE = 7, 6
"""Numbers in a pose (position, quaternion) and in a velocity (linear, angular)."""


class PyBulletWorld:
    """Rigid bodies that their drives push; implements the `World` protocol.

    Parameters
    ----------
    config : SimConfig
    scene : Scene
        Checked scene.
    seed : int
        Seed of the run; shapes the terrain, and the slip of wheels.

    Raises
    ------
    PhysicsError
        If the engine does not start or refuses a body.
    """

    has_contacts = True

    def __init__(self, config: SimConfig, scene: Scene, seed: int) -> None:
        types = [robot.type for robot in scene.robots]
        self._grid = TickGrid.of(config.period_s, config.physics.rate_hz)
        yaws = wrap_angle(np.array([robot.yaw for robot in scene.robots]))
        self._drive = make_drive(config, types, yaws, self._grid.step_s, seed)
        terrain = make_terrain(config.terrain, scene.bounds, seed)
        self._floor = float(terrain.heights.min()) - SINK_LIMIT_M

        self._client = open_server()
        try:
            self._bodies = _SceneBuilder(self._client, self._grid.step_s).build(config, scene, terrain)
            self._state = self._read()
            for _ in range(round(SETTLING_S / config.period_s) or 1):
                self.advance(np.zeros((len(types), 3)))
        except BaseException:
            self.close()
            raise

    @property
    def state(self) -> BodyState:
        """Return the true state now."""
        return self._state

    def advance(self, setpoints: FloatArray) -> Motion:
        """Run one control period; see `World.advance`."""
        if self._client < 0:
            raise PhysicsError("the world is closed")
        start = self._state
        grid, drive = self._grid, self._drive
        velocities, yaw_rates, yaws = start.velocities, start.yaw_rates, start.yaws
        centers = np.column_stack([start.positions, start.heights])
        forces = np.zeros_like(centers)
        states, sampled = [], set(grid.sampled.tolist())
        for k in range(1, grid.steps + 1):
            forces[:, :2], torques = drive.push(setpoints, velocities, yaws, yaw_rates)
            self._push(forces, centers, torques)
            pybullet.stepSimulation(self._client)
            if k in sampled:
                state = self._read()
                states.append(state)
                velocities, yaw_rates, yaws = state.velocities, state.yaw_rates, state.yaws
                centers = np.column_stack([state.positions, state.heights])
            else:
                # Between samples one call per body is enough: Bullet moves a body by its new velocity, so adding that
                # up follows the center of mass to within what contacts correct.
                spins = self._read_velocities()
                velocities, yaw_rates = spins[:, :2], spins[:, 5]
                centers = centers + grid.step_s * spins[:, :3]
                yaws = yaws + grid.step_s * yaw_rates
        self._state = states[-1]
        if self._state.heights.min() < self._floor:
            raise PhysicsError(f"robot in row {int(self._state.heights.argmin())} of the scene fell off the ground")
        samples = np.stack([state.positions for state in states])
        speeds = np.stack([state.velocities for state in states])
        return motion_between(start, self._state, samples, speeds, grid.period_s)

    def close(self) -> None:
        """Stop the physics server; may be called again."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def _push(self, forces: FloatArray, centers: FloatArray, torques: FloatArray) -> None:
        """Apply drive forces (n, 3) at the centers (n, 3), and turning torques (n,), for the next step."""
        client, frame, push = self._client, pybullet.WORLD_FRAME, pybullet.applyExternalForce
        for body, force, center in zip(self._bodies, forces.tolist(), centers.tolist(), strict=True):
            push(body, -1, force, center, frame, client)
        for row in np.flatnonzero(torques):
            torque = (0.0, 0.0, float(torques[row]))
            pybullet.applyExternalTorque(self._bodies[row], -1, torque, frame, client)

    def _read_velocities(self) -> FloatArray:
        """Return linear and angular velocities (n, 6), world frame."""
        client, read = self._client, pybullet.getBaseVelocity
        flat = chain.from_iterable(chain.from_iterable([read(body, client) for body in self._bodies]))
        return np.fromiter(flat, np.float64, VELOCITY_SIZE * len(self._bodies)).reshape(-1, VELOCITY_SIZE)

    def _read(self) -> BodyState:
        client = self._client
        read = pybullet.getBasePositionAndOrientation
        flat = chain.from_iterable(chain.from_iterable([read(body, client) for body in self._bodies]))
        table = np.fromiter(flat, np.float64, POSE_SIZE * len(self._bodies)).reshape(-1, POSE_SIZE)
        spins = self._read_velocities()
        x, y, z, w = table[:, 3:].T
        yaws = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return BodyState(
            frozen(table[:, :2]),
            frozen(table[:, 2]),
            frozen(wrap_angle(yaws)),
            frozen(spins[:, :2]),
            frozen(spins[:, 5]),
        )


class _SceneBuilder:
    """Puts ground, walls and robots into a physics server."""

    def __init__(self, client: int, step_s: float) -> None:
        self._client = client
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=step_s,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )

    def build(self, config: SimConfig, scene: Scene, terrain: Terrain) -> list[int]:
        """Return the robots' body numbers, in the scene's order."""
        types = [robot.type for robot in scene.robots]
        # sqrt(mu1) on every hull makes the product of two equal hulls mu1; walls are as grippy as the mean robot.
        grip = float(np.mean([np.sqrt(robot_type.mu1) for robot_type in types]))
        self._add_ground(config.terrain.ground, terrain)
        for polygon in scene.obstacles:
            for piece in convex_pieces(polygon):
                self._add_wall(piece, terrain, grip)
        for side in _fence(terrain):
            self._add_wall(side, terrain, grip)
        bodies = {robot_type: Chassis.of(robot_type, config.drive) for robot_type in dict.fromkeys(types)}
        shapes = {robot_type: self._chassis_shape(chassis) for robot_type, chassis in bodies.items()}
        return [self._add_robot(robot, bodies[robot.type], shapes[robot.type], terrain) for robot in scene.robots]

    def _add_ground(self, ground: Ground, terrain: Terrain) -> None:
        if ground is Ground.PLANE:
            shape, center = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self._client), 0.0
        else:
            rows, columns = terrain.heights.shape
            shape = pybullet.createCollisionShape(
                pybullet.GEOM_HEIGHTFIELD,
                meshScale=[CELL_M, CELL_M, 1.0],
                heightfieldData=terrain.heights.ravel().tolist(),
                numHeightfieldRows=columns,  # Bullet's rows are the points along x
                numHeightfieldColumns=rows,
                physicsClientId=self._client,
            )
            # Bullet puts the middle between the lowest and the highest point at the body's origin.
            center = float(terrain.heights.min() + terrain.heights.max()) / 2.0
        self._add_static(shape, (*terrain.center, center), 0.0)

    def _add_wall(self, corners: FloatArray, terrain: Terrain, friction: float) -> None:
        levels = terrain.heights.min() - WALL_DEPTH_M, terrain.heights.max() + WALL_HEIGHT_M
        low, high = (np.column_stack([corners, np.full(len(corners), level)]) for level in levels)
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_MESH, vertices=np.concatenate([low, high]).tolist(), physicsClientId=self._client
        )
        self._add_static(shape, (0.0, 0.0, 0.0), friction)

    def _add_static(self, shape: int, position: tuple[float, float, float], friction: float) -> None:
        body = self._add_body(0.0, shape, position, (0.0, 0.0, 0.0, 1.0))
        pybullet.changeDynamics(body, -1, lateralFriction=friction, physicsClientId=self._client)
        pybullet.setCollisionFilterGroupMask(body, -1, STATIC_GROUP, ROBOT_GROUP, physicsClientId=self._client)

    def _chassis_shape(self, chassis: Chassis) -> int:
        spheres = len(chassis.spheres)
        shape: int = pybullet.createCollisionShapeArray(
            shapeTypes=[pybullet.GEOM_SPHERE] * spheres + [pybullet.GEOM_CYLINDER],
            radii=[chassis.sphere_radius] * spheres + [chassis.hull_radius],
            lengths=[0.0] * spheres + [chassis.hull_length],
            collisionFramePositions=[*chassis.spheres.tolist(), [0.0, 0.0, chassis.hull_center]],
            collisionFrameOrientations=[[0.0, 0.0, 0.0, 1.0]] * (spheres + 1),
            physicsClientId=self._client,
        )
        return shape

    def _add_robot(self, robot: RobotSpec, chassis: Chassis, shape: int, terrain: Terrain) -> int:
        robot_type = robot.type
        height, orientation = _stand(chassis, np.array(robot.position), robot.yaw, terrain)
        body = self._add_body(robot_type.mass_kg, shape, (*robot.position, height), orientation)
        pybullet.changeDynamics(
            body,
            -1,
            mass=robot_type.mass_kg,  # without it, setting the inertia clears the mass
            lateralFriction=float(np.sqrt(robot_type.mu1)),
            linearDamping=0.0,
            angularDamping=ANGULAR_DAMPING,
            localInertiaDiagonal=chassis.inertia,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self._client,
        )
        pybullet.setCollisionFilterGroupMask(
            body, -1, ROBOT_GROUP, ROBOT_GROUP | STATIC_GROUP, physicsClientId=self._client
        )
        return body

    def _add_body(
        self,
        mass: float,
        shape: int,
        position: tuple[float, float, float],
        orientation: tuple[float, float, float, float],
    ) -> int:
        if shape < 0:
            raise PhysicsError("PyBullet refused a collision shape of the scene; simplify the obstacles")
        body: int = pybullet.createMultiBody(
            mass,
            shape,
            basePosition=position,
            baseOrientation=orientation,
            useMaximalCoordinates=1,  # plain rigid bodies: three times faster than one-link multibodies
            physicsClientId=self._client,
        )
        if body < 0:
            raise PhysicsError("PyBullet refused a body of the scene; simplify the obstacles")
        return body


def _stand(
    chassis: Chassis, point: FloatArray, yaw: float, terrain: Terrain
) -> tuple[float, tuple[float, float, float, float]]:
    """Return height of the center and orientation (x, y, z, w) of a robot that stands on the ground at `point`."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    feet = chassis.spheres[:, :2] @ np.array([[cos, sin], [-sin, cos]])
    ground = terrain.heights_at(point + feet)
    # The plane through three or four feet, evenly spread on a circle: least squares has this closed form.
    slope = feet.T @ (ground - ground.mean()) / (feet[:, 0] ** 2).sum()
    lift = float((ground - feet @ slope).max())
    # Turn about the vertical, then tilt the vertical onto the plane's normal.
    normal = np.array([-slope[0], -slope[1], 1.0]) / np.sqrt(1.0 + slope @ slope)
    half = np.array([-normal[1], normal[0], 0.0, 1.0 + normal[2]])
    tilt = half / np.linalg.norm(half)
    _, orientation = pybullet.multiplyTransforms(
        [0.0, 0.0, 0.0], tilt.tolist(), [0.0, 0.0, 0.0], [0.0, 0.0, float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0))]
    )
    return lift + chassis.center_height * float(np.sqrt(1.0 + slope @ slope)), orientation


def _fence(terrain: Terrain) -> list[FloatArray]:
    """Return the four walls along the inside of the ground's edge, as rectangles."""
    (x0, y0), (rows, columns) = terrain.origin, terrain.heights.shape
    x1, y1 = x0 + (columns - 1) * CELL_M, y0 + (rows - 1) * CELL_M
    t = FENCE_THICKNESS_M
    boxes = [(x0, y0, x1, y0 + t), (x0, y1 - t, x1, y1), (x0, y0, x0 + t, y1), (x1 - t, y0, x1, y1)]
    return [np.array([(a, b), (c, b), (c, d), (a, d)]) for a, b, c, d in boxes]
