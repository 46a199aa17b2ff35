"""The thesis' forces in the numbers that spec section 8.2 gives."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.shape import load_shape
from swarm_agent.forces.config import LiteralForceConfig
from swarm_agent.forces.force_law import Others
from swarm_agent.forces.literal_law import Forces, LiteralLaw
from swarm_msgs_py.types import FloatArray

CIRCLE = load_shape("iso_1_circle")
RADIUS = 0.15


def forces_at(points: FloatArray, contour: FloatArray = CIRCLE, **gains: float) -> Forces:
    """Return the forces on robots that hear nobody."""
    law = LiteralLaw(LiteralForceConfig(**gains), contour, (), 0.1)
    alone = Others(np.empty((0, 2)), np.empty(0), np.ones((len(points), 0), dtype=np.bool_))
    return law.forces(points, np.full(len(points), RADIUS), alone)


def intermember(distance: float, radii: tuple[float, float] = (0.15, 0.15)) -> FloatArray:
    """Return the intermember forces on two robots on the x axis."""
    points, sizes = np.array([[0.0, 0.0], [distance, 0.0]]), np.array(radii)
    law = LiteralLaw(LiteralForceConfig(), CIRCLE, (), 0.1)
    return law.forces(points, sizes, Others.each_other(points, sizes)).intermember


def test_twenty_meters_from_the_center_attraction_and_transition_are_as_specified() -> None:
    forces = forces_at(np.array([[20.0, 0.0]]))

    assert forces.attractive[0, 0] == pytest.approx(-5000.0, rel=0.01)
    assert forces.transition[0, 0] == pytest.approx(-940.0, rel=0.01)


def test_outside_nothing_repels_and_inside_nothing_attracts() -> None:
    forces = forces_at(np.array([[15.0, 0.0], [5.0, 0.0]]))

    assert_allclose(forces.repulsive[0], 0.0)
    assert_allclose(forces.attractive[1], 0.0)
    assert_allclose(forces.transition[1], 0.0)
    assert forces.repulsive[1, 0] < 0.0


def test_inside_the_buffer_the_forces_blend_linearly_and_continuously() -> None:
    depths = np.array([-1e-9, 1e-9, 0.25, 0.5, 0.75, 1.0 - 1e-9, 1.0 + 1e-9])
    edge = CIRCLE[:2].mean(axis=0)
    inward = -edge / np.linalg.norm(edge)
    points = edge + depths[:, None] * inward

    forces = forces_at(points)
    # Without a band there is nothing but the repulsion inside.
    full = forces_at(points[1:], buffer_m=1e-12).repulsive @ inward

    shares = forces.repulsive[1:] @ inward / full
    assert_allclose(shares, np.clip(depths[1:], 0.0, 1.0), rtol=1e-3, atol=1e-3)
    pull = (forces.attractive + forces.transition) @ inward
    assert pull[0] == pytest.approx(pull[1], rel=1e-5)
    assert np.all(np.diff(pull) < 0.0)
    assert pull[-1] == pytest.approx(0.0, abs=1e-4)


def test_beyond_the_buffer_nothing_pushes_outward() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    inward = -np.column_stack([np.cos(angles), np.sin(angles)])

    for distance in (9.0, 9.5, 9.99, 10.01, 12.0):
        assert ((forces_at(-distance * inward).total * inward).sum(axis=1) > 0.0).all()


def test_the_intermember_force_is_as_specified_at_a_gap_of_almost_two_meters() -> None:
    assert_allclose(intermember(1.9 + 0.3), [[-415.5, 0.0], [415.5, 0.0]], rtol=1e-3)


def test_robots_of_different_size_push_each_other_by_their_gap() -> None:
    assert_allclose(intermember(2.0, (0.15, 0.5)), intermember(2.0 - 0.35))


@pytest.mark.parametrize("distance", [0.0, 0.1, 0.3, 0.34])
def test_touching_and_overlapping_robots_push_as_hard_as_the_law_ever_does(distance: float) -> None:
    push = np.abs(intermember(distance)[:, 0])

    strongest = 1500.0 / 0.05**2
    assert_allclose(push, 0.0 if distance == 0.0 else strongest)


def test_who_was_not_heard_does_not_push() -> None:
    points, radii = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]), np.full(3, RADIUS)
    heard = np.array([[False, False, True], [False, False, False], [True, False, False]])
    law = LiteralLaw(LiteralForceConfig(), CIRCLE, (), 0.1)

    push = law.forces(points, radii, Others(points, radii, heard)).intermember

    assert push[0, 0] == 0.0
    assert push[0, 1] < 0.0
    assert_allclose(push[1], 0.0)


def test_outside_a_bay_the_forces_vanish_where_the_specification_says() -> None:
    # formation_2 has its boundary center in the bay: the zero of the outer forces lies there too (spec 8.4).
    contour = load_shape("formation_2")

    forces = forces_at(np.array([[5.8, -6.0]]), contour)

    assert np.linalg.norm(forces.total) < 100.0
