"""Floating cubes with contacts, held together by breakable constraints, by PyBullet.

A hull rests on the buoyancy of its four quarters, which rights it when it heels; it heaves, rolls and pitches. Its mass
is that of surge and sway, added mass included; what that weighs more than the boat is carried by the water.
"""

from __future__ import annotations

from itertools import chain

import numpy as np

from swarm_msgs_py.errors import PhysicsError
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import BoatsConfig
from swarm_sim.bullet import open_server, pybullet
from swarm_sim.gravity import GRAVITY

WATER_KGPM3 = 1000.0
HULL_HEIGHT_M = 0.16
"""Height of the hull; most of it is above the water."""
HEAVE_DAMPING = 0.4
"""Of heave, roll and pitch, as a share of the critical."""
HULL_FRICTION = 0.2
"""Wet plastic on wet plastic."""
ALIGNING_ERP = 0.03
"""Share of a latched pair's misalignment that is corrected per physics step: a tenth of a second at 200 Hz."""
SOLVER_ITERATIONS = 40
"""Latched boats are chains and rings of constraints; fewer let large structures stretch."""
TORN_STEPS = 3
"""Physics steps in a row at the magnets' force that tear a pair apart."""
CONSTRAINT_ROOM = 4.0
"""The solver may use this multiple of the magnets' force, so that a pull beyond it shows."""
POSE_SIZE, VELOCITY_SIZE = 7, 6


class BulletBoats:
    """Implements `Bodies`.

    Parameters
    ----------
    config : BoatsConfig
    poses : (n, 3) array
        At the start.

    Raises
    ------
    PhysicsError
        If the engine does not start or refuses a body.
    """

    def __init__(self, config: BoatsConfig, poses: FloatArray) -> None:
        hull = config.hull
        self._hull = hull
        self._tear_n = config.magnets.force_n
        self._substeps = max(1, round(config.physics_hz / config.control_hz))
        self._step_s = 1.0 / config.control_hz / self._substeps
        area = hull.side_m**2
        self._float = WATER_KGPM3 * GRAVITY * area  # force per draft [N/m]
        self._draft = hull.dry_mass_kg / (WATER_KGPM3 * area)
        self._righting = self._float * hull.side_m**2 / 12.0  # moment per angle, waterplane's second moment
        self._heave_drag = 2.0 * HEAVE_DAMPING * np.sqrt(self._float * hull.mass_kg)
        self._roll_drag = 2.0 * HEAVE_DAMPING * np.sqrt(self._righting * hull.inertia_kgm2)
        self._latches: dict[Latch, int] = {}
        self._strained: dict[Latch, int] = {}
        self._torn: list[Latch] = []
        self._client = open_server()
        try:
            self._bodies = self._build(np.asarray(poses, dtype=np.float64))
        except BaseException:
            self.close()
            raise
        self._read()

    def step(self, wrenches: FloatArray) -> None:
        """Advance by one control step; see `Bodies.step`."""
        if self._client < 0:
            raise PhysicsError("the world is closed")
        for _ in range(self._substeps):
            self._push(wrenches)
            pybullet.stepSimulation(self._client)
            self._read()
            self._tear()

    def latch(self, latch: Latch) -> None:
        """Hold two boats together; see `Bodies.latch`."""
        client = self._client
        pivot = [*latch.offset.tolist(), 0.0]
        turn = pybullet.getQuaternionFromEuler([0.0, 0.0, latch.turn])
        constraint: int = pybullet.createConstraint(
            self._bodies[latch.boat],
            -1,
            self._bodies[latch.other],
            -1,
            pybullet.JOINT_FIXED,
            [0.0, 0.0, 0.0],
            pivot,
            [0.0, 0.0, 0.0],
            parentFrameOrientation=turn,
            physicsClientId=client,
        )
        if constraint < 0:
            raise PhysicsError("PyBullet refused to join two boats")
        room = CONSTRAINT_ROOM * self._tear_n
        pybullet.changeConstraint(constraint, maxForce=room, erp=ALIGNING_ERP, physicsClientId=client)
        self._latches[latch] = constraint
        self._collide(latch, is_on=False)

    def release(self, latch: Latch) -> None:
        """Let two boats go; see `Bodies.release`."""
        pybullet.removeConstraint(self._latches.pop(latch), self._client)
        self._strained.pop(latch, None)
        self._collide(latch, is_on=True)

    def torn(self) -> list[Latch]:
        """Return the latches that were pulled apart since the last call; see `Bodies.torn`."""
        found, self._torn = self._torn, []
        return found

    def close(self) -> None:
        """Stop the physics server; may be called again."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def _collide(self, latch: Latch, is_on: bool) -> None:
        """Let two hulls touch or not: the solver of latched boats has enough to do without their contact."""
        pair = self._bodies[latch.boat], self._bodies[latch.other]
        pybullet.setCollisionFilterPair(*pair, -1, -1, int(is_on), self._client)

    def _tear(self) -> None:
        for latch, constraint in list(self._latches.items()):
            force = pybullet.getConstraintState(constraint, self._client)[:3]
            if np.sqrt(sum(part * part for part in force)) < self._tear_n:
                self._strained.pop(latch, None)
                continue
            self._strained[latch] = self._strained.get(latch, 0) + 1
            if self._strained[latch] >= TORN_STEPS:
                self.release(latch)
                self._torn.append(latch)

    def _push(self, wrenches: FloatArray) -> None:
        """Apply wrenches (n, 3), drag and buoyancy for the next physics step."""
        hull, speeds = self._hull, self._speeds
        planar = wrenches[:, :2] - hull.drag_nspm * speeds[:, :2]
        lift = np.maximum(self._float * (self._draft - self._heights), 0.0) + hull.added_mass_kg * GRAVITY
        heave = lift - self._heave_drag * speeds[:, 2]
        # A tilted hull is righted about the horizontal axis on which its own vertical leans.
        lean = np.column_stack([-self._up[:, 1], self._up[:, 0]])
        roll = -self._righting * lean - self._roll_drag * speeds[:, 3:5]
        yaw = wrenches[:, 2] - hull.yaw_drag_nms * speeds[:, 5]
        client, frame = self._client, pybullet.WORLD_FRAME
        forces = np.column_stack([planar, heave])
        torques = np.column_stack([roll, yaw])
        for body, force, torque, center in zip(
            self._bodies, forces.tolist(), torques.tolist(), self._centers, strict=True
        ):
            pybullet.applyExternalForce(body, -1, force, center, frame, client)
            pybullet.applyExternalTorque(body, -1, torque, frame, client)

    def _read(self) -> None:
        client = self._client
        reads = [pybullet.getBasePositionAndOrientation(body, client) for body in self._bodies]
        flat = chain.from_iterable(chain.from_iterable(reads))
        table = np.fromiter(flat, np.float64, POSE_SIZE * len(reads)).reshape(-1, POSE_SIZE)
        spins = chain.from_iterable(chain.from_iterable(pybullet.getBaseVelocity(b, client) for b in self._bodies))
        self._speeds = np.fromiter(spins, np.float64, VELOCITY_SIZE * len(reads)).reshape(-1, VELOCITY_SIZE)
        self._centers = [read[0] for read in reads]
        self._heights = table[:, 2]
        x, y, z, w = table[:, 3:].T
        self._up = np.column_stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x)])  # where the hull's vertical points
        yaws = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        self.poses = np.column_stack([table[:, :2], yaws])
        self.velocities = self._speeds[:, [0, 1, 5]]

    def _build(self, poses: FloatArray) -> list[int]:
        client, hull = self._client, self._hull
        pybullet.setGravity(0.0, 0.0, -GRAVITY, physicsClientId=client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=self._step_s,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
            physicsClientId=client,
        )
        half = [0.5 * hull.side_m, 0.5 * hull.side_m, 0.5 * HULL_HEIGHT_M]
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
        return [self._add(shape, *pose) for pose in poses.tolist()]

    def _add(self, shape: int, x: float, y: float, yaw: float) -> int:
        hull = self._hull
        orientation = pybullet.getQuaternionFromEuler([0.0, 0.0, yaw])
        body: int = pybullet.createMultiBody(
            hull.mass_kg,
            shape,
            basePosition=[x, y, 0.0],  # height 0: floats at its draft
            baseOrientation=orientation,
            physicsClientId=self._client,
        )
        if body < 0:
            raise PhysicsError("PyBullet refused the hull of a boat")
        pybullet.changeDynamics(
            body,
            -1,
            localInertiaDiagonal=[hull.inertia_kgm2] * 3,
            linearDamping=0.0,
            angularDamping=0.0,
            lateralFriction=HULL_FRICTION,
            restitution=0.0,
            activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING,
            physicsClientId=self._client,
        )
        return body
