"""Boats as bodies: Fossen's equations in the plane, groups as rigid bodies, floating cubes with breakable joints."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.errors import PhysicsError
from swarm_sim.boats.bodies import Bodies, Latch
from swarm_sim.boats.config import CELL_M, BoatsConfig
from swarm_sim.boats.planar_bodies import PlanarBodies
from swarm_sim.boats.pool import BodyKind, make_bodies
from swarm_sim.world.pybullet_boats import BulletBoats

CONFIG = BoatsConfig()
STEP_S = 1.0 / CONFIG.control_hz
SIDE_BY_SIDE = np.array([[0.0, 0.0, 0.0], [CELL_M + 0.006, 0.004, 0.03]])
LATCH = Latch(0, 1, Face.RIGHT, Face.LEFT)


def run(bodies: Bodies, wrenches: np.ndarray, duration_s: float) -> None:
    for _ in range(round(duration_s / STEP_S)):
        bodies.step(wrenches)


def test_planar_boats_move_as_fossens_equations_in_the_body_frame_say() -> None:
    hull = CONFIG.hull
    m, inertia, drag, yaw_drag = hull.mass_kg, hull.inertia_kgm2, hull.drag_nspm, hull.yaw_drag_nms
    push = np.array([0.8, -0.3, 0.02])  # body frame

    def rates(_t: float, state: np.ndarray) -> list[float]:
        _, _, psi, u, v, r = state
        du = (push[0] - drag * u + m * v * r) / m  # C(v) of eq. (6): -m2 v r in surge, m1 u r in sway
        dv = (push[1] - drag * v - m * u * r) / m
        dr = (push[2] - yaw_drag * r) / inertia
        return [u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi), r, du, dv, dr]

    exact = solve_ivp(rates, (0.0, 4.0), np.zeros(6), rtol=1e-9, atol=1e-9).y[:3, -1]
    bodies = PlanarBodies(hull, np.zeros((1, 3)), 0.001)
    for _ in range(4000):
        psi = bodies.poses[0, 2]
        force = [push[0] * np.cos(psi) - push[1] * np.sin(psi), push[0] * np.sin(psi) + push[1] * np.cos(psi)]
        bodies.step(np.array([[*force, push[2]]]))

    assert np.allclose(bodies.poses[0], exact, atol=5e-3)


@pytest.mark.parametrize("kind", list(BodyKind))
def test_latched_boats_are_drawn_into_line_and_move_as_one(kind: BodyKind) -> None:
    bodies = make_bodies(kind, CONFIG, SIDE_BY_SIDE)
    try:
        bodies.latch(LATCH)
        run(bodies, np.array([[0.0, 0.5, 0.0], [0.0, 0.5, 0.0]]), 3.0)
        offset = bodies.poses[1, :2] - bodies.poses[0, :2]
        yaw = bodies.poses[0, 2]

        assert np.hypot(*offset) == pytest.approx(CELL_M, abs=1e-3)
        assert np.arctan2(offset[1], offset[0]) == pytest.approx(yaw, abs=0.01)
        assert bodies.poses[1, 2] == pytest.approx(yaw, abs=0.01)
        assert bodies.velocities[0, 1] == pytest.approx(0.25 * (1.0 - np.exp(-3.0 * 2.0 / 3.1)), rel=0.05)
        assert bodies.torn() == []
    finally:
        bodies.close()


@pytest.mark.parametrize("kind", list(BodyKind))
def test_boats_that_were_let_go_drift_apart(kind: BodyKind) -> None:
    bodies = make_bodies(kind, CONFIG, SIDE_BY_SIDE)
    try:
        bodies.latch(LATCH)
        bodies.release(LATCH)
        run(bodies, np.array([[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]), 2.0)

        assert bodies.poses[1, 0] - bodies.poses[0, 0] > 2.0 * CELL_M
    finally:
        bodies.close()


def test_a_docked_group_keeps_its_momentum_when_it_is_made_rigid() -> None:
    bodies = PlanarBodies(CONFIG.hull, SIDE_BY_SIDE, STEP_S)
    bodies.velocities = np.array([[0.2, 0.0, 0.0], [-0.1, 0.1, 0.5]])
    mean = bodies.velocities[:, :2].mean(axis=0)
    bodies.latch(LATCH)

    bodies.step(np.zeros((2, 3)))

    decay = np.exp(-CONFIG.hull.drag_nspm / CONFIG.hull.mass_kg * STEP_S)
    assert np.allclose(bodies.velocities[:, :2].mean(axis=0), decay * mean)
    assert bodies.velocities[0, 2] == pytest.approx(bodies.velocities[1, 2])


def test_a_hull_in_bullet_floats_at_rest_and_rights_itself() -> None:
    bodies = BulletBoats(CONFIG, np.zeros((1, 3)))
    try:
        run(bodies, np.array([[0.3, 0.0, 0.0]]), 3.0)

        assert bodies.poses[0, 0] > 0.2
        assert bodies._heights[0] == pytest.approx(0.0, abs=0.005)
        assert np.abs(bodies._up).max() < 0.02
    finally:
        bodies.close()


@pytest.mark.parametrize(("pull", "holds"), [(80.0, True), (160.0, False)])
def test_magnets_in_bullet_tear_beyond_their_force_and_not_before(pull: float, holds: bool) -> None:
    aligned = np.array([[0.0, 0.0, 0.0], [CELL_M, 0.0, 0.0]])
    bodies = BulletBoats(CONFIG, aligned)
    try:
        bodies.latch(LATCH)
        torn = []
        for _ in range(20):
            bodies.step(np.array([[-pull, 0.0, 0.0], [pull, 0.0, 0.0]]))
            torn += bodies.torn()

        assert torn == ([] if holds else [LATCH])
    finally:
        bodies.close()


def test_a_closed_pool_refuses_to_go_on() -> None:
    bodies = BulletBoats(CONFIG, np.zeros((1, 3)))
    bodies.close()
    bodies.close()

    with pytest.raises(PhysicsError, match="closed"):
        bodies.step(np.zeros((1, 3)))
