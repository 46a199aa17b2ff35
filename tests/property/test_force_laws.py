"""What must hold for forces among any contour, obstacles and robots."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from swarm_agent.forces.config import ForceConfig, ForceLawName, LiteralForceConfig
from swarm_agent.forces.force_drive import ForceDrive
from swarm_agent.forces.force_law import Others
from swarm_agent.forces.literal_law import LiteralLaw
from swarm_agent.forces.registry import law_for
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals
from swarm_msgs_py.types import FloatArray

BLOCK = np.array([[14.0, -2.0], [16.0, -2.0], [16.0, 3.0], [14.0, 3.0]])
RADII = np.array([0.15, 0.3, 0.5])
angles = st.floats(0.0, 2.0 * np.pi)
shifts = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)).map(np.array)
seeds = st.integers(0, 10_000)


def star(seed: int, corners: int = 9) -> FloatArray:
    """Return a star-shaped contour about the origin, counter-clockwise."""
    rng = np.random.default_rng(seed)
    turns = 2.0 * np.pi * (np.arange(corners) + rng.uniform(0.0, 0.6, corners)) / corners
    return rng.uniform(3.0, 10.0, corners)[:, None] * np.column_stack([np.cos(turns), np.sin(turns)])


def swarm(seed: int, count: int = 12) -> tuple[FloatArray, FloatArray]:
    """Return places and radii of robots that do not touch, clear of the block."""
    rng = np.random.default_rng(seed + 1)
    grid = np.stack(np.meshgrid(np.linspace(-12.0, 12.0, 7), np.linspace(-12.0, 12.0, 7)), axis=-1).reshape(-1, 2)
    places = rng.permutation(grid)[:count] + rng.uniform(-1.0, 1.0, (count, 2))
    return places, rng.choice(RADII, count)


def rotation(angle: float) -> FloatArray:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


@settings(max_examples=25)
@given(seeds, angles, shifts)
def test_the_literal_forces_turn_and_move_with_the_scene(seed: int, angle: float, shift: FloatArray) -> None:
    contour, (places, radii), turn = star(seed), swarm(seed), rotation(angle)

    here = LiteralLaw(LiteralForceConfig(), contour, (BLOCK,), 0.1)
    there = LiteralLaw(LiteralForceConfig(), contour @ turn + shift, (BLOCK @ turn + shift,), 0.1)
    moved = places @ turn + shift

    forces = here.evaluate(places, radii, Others.each_other(places, radii))
    assert_allclose(
        there.evaluate(moved, radii, Others.each_other(moved, radii)), forces @ turn, rtol=1e-6, atol=1e-6 * 1500.0
    )


@settings(max_examples=10)
@given(seeds, shifts)
def test_the_forces_of_the_own_variant_move_with_the_scene(seed: int, shift: FloatArray) -> None:
    contour, (places, radii) = star(seed), swarm(seed)
    config, moved = ForceConfig(), places + shift

    forces = law_for(ForceLawName.SHARING, config, contour, (BLOCK,), PlanningConfig()).evaluate(
        places, radii, Others.each_other(places, radii)
    )
    others = law_for(ForceLawName.SHARING, config, contour + shift, (BLOCK + shift,), PlanningConfig()).evaluate(
        moved, radii, Others.each_other(moved, radii)
    )

    # Points of the lattice that lie on the line between two robots may fall to either.
    assert_allclose(others, forces, atol=0.05 * config.f_sat)


@settings(max_examples=25)
@given(seeds)
def test_robots_that_hear_each_other_push_with_equal_and_opposite_forces(seed: int) -> None:
    places, radii = swarm(seed)
    law = LiteralLaw(LiteralForceConfig(), star(seed), (), 0.1)

    push = law.forces(places, radii, Others.each_other(places, radii)).intermember

    assert_allclose(push.sum(axis=0), 0.0, atol=1e-9 * np.abs(push).sum())


@settings(max_examples=25)
@given(seeds)
def test_many_robots_at_once_feel_what_each_feels_alone(seed: int) -> None:
    places, radii = swarm(seed)
    for law in (law_for(name, ForceConfig(), star(seed), (BLOCK,), PlanningConfig()) for name in ForceLawName):
        together = law.evaluate(places, radii, Others.each_other(places, radii))
        for row in range(len(places)):
            heard = np.arange(len(places))[None] != row
            alone = law.evaluate(places[row : row + 1], radii[row : row + 1], Others(places, radii, heard))
            assert_allclose(alone[0], together[row], rtol=1e-9, atol=1e-6)


@settings(max_examples=25)
@given(seeds)
def test_the_signed_distance_says_how_far_the_contour_is_and_on_which_side(seed: int) -> None:
    contour = star(seed)
    points = np.random.default_rng(seed).uniform(-12.0, 12.0, (40, 2))

    at = ContourIntegrals(contour).at(points)
    edges = contour[None] + np.linspace(0.0, 1.0, 400)[:, None, None] * (np.roll(contour, -1, axis=0) - contour)
    nearest = np.linalg.norm(points[:, None] - edges.reshape(-1, 2), axis=2).min(axis=1)

    assert_allclose(np.abs(at.signed_distances), nearest, atol=0.03)
    assert ((at.signed_distances > 0.0) == at.inside).all()


@settings(max_examples=15)
@given(seeds, st.sampled_from(list(ForceLawName)), st.sampled_from([0.05, 0.5, 1.0]))
def test_velocities_stay_within_the_limit_and_are_finite(seed: int, name: ForceLawName, period: float) -> None:
    places, radii = swarm(seed)
    places[1] = places[0]  # two robots in one place
    places[2] = star(seed)[0]  # one on a corner of the shape
    config = ForceConfig()
    law = law_for(name, config, star(seed), (BLOCK,), PlanningConfig())

    velocities = ForceDrive(config, period, len(places)).step(
        law, places, radii, Others.each_other(places, radii), np.zeros_like(places)
    )

    assert np.isfinite(velocities).all()
    assert np.linalg.norm(velocities, axis=1).max() <= config.speed_max_m_s + 1e-12


def test_equal_inputs_give_equal_bytes() -> None:
    places, radii = swarm(4)
    for name in ForceLawName:
        results = []
        for _ in range(2):
            law_for.__globals__["_law"].cache_clear()
            law = law_for(name, ForceConfig(), star(4), (BLOCK,), PlanningConfig())
            results.append(law.evaluate(places, radii, Others.each_other(places, radii)).tobytes())
        assert results[0] == results[1]


@pytest.mark.parametrize("name", list(ForceLawName))
def test_forces_are_defined_without_others_and_without_obstacles(name: ForceLawName) -> None:
    law = law_for(name, ForceConfig(), star(1), (), PlanningConfig())
    nobody = Others(np.empty((0, 2)), np.empty(0), np.ones((1, 0), dtype=np.bool_))

    assert np.isfinite(law.evaluate(np.array([[20.0, 1.0]]), np.array([0.3]), nobody)).all()
