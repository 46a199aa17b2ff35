import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.shape import load_shape
from swarm_agent.forces.config import ForceConfig
from swarm_agent.forces.force_law import Others
from swarm_agent.forces.sharing_law import SharingLaw
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.types import FloatArray

F_SAT = ForceConfig().f_sat
SQUARE = np.array([[-8.0, -8.0], [8.0, -8.0], [8.0, 8.0], [-8.0, 8.0]])
WALL = np.array([[20.0, -15.0], [21.0, -15.0], [21.0, 5.0], [20.0, 5.0]])
RADIUS = 0.3


def force_on(
    position: tuple[float, float],
    others: FloatArray | None = None,
    contour: FloatArray = SQUARE,
    obstacles: tuple[FloatArray, ...] = (),
) -> FloatArray:
    around = np.empty((0, 2)) if others is None else np.asarray(others, dtype=float)
    law = SharingLaw(ForceConfig(), contour, obstacles, PlanningConfig())
    heard = np.ones((1, len(around)), dtype=np.bool_)
    return law.evaluate(np.array([position]), np.array([RADIUS]), Others(around, np.full(len(around), RADIUS), heard))[
        0
    ]


def test_outside_the_force_is_one_of_full_speed_to_the_nearest_place_inside() -> None:
    assert_allclose(force_on((30.0, 3.0)), [-F_SAT, 0.0], atol=1e-6 * F_SAT)


def test_in_the_middle_of_the_shape_a_robot_alone_feels_nothing() -> None:
    assert_allclose(force_on((0.0, 0.0)), [0.0, 0.0], atol=0.1 * F_SAT)


def test_a_wall_in_the_way_is_gone_around() -> None:
    force = force_on((30.0, 3.0), obstacles=(WALL,))

    toward_corner = np.array([21.0 + 0.4, 5.0 + 0.4]) - np.array([30.0, 3.0])
    assert np.linalg.norm(force) == pytest.approx(F_SAT)
    assert force @ toward_corner > 0.99 * F_SAT * np.linalg.norm(toward_corner)


def test_the_boundary_center_in_a_bay_attracts_nobody() -> None:
    contour = load_shape("formation_2")

    force = force_on((5.8, -5.8), contour=contour)  # where the thesis' forces vanish

    assert np.linalg.norm(force) > 0.5 * F_SAT


def test_a_robot_that_others_pushed_against_a_wall_is_pushed_back() -> None:
    touching = (21.0 + RADIUS, -5.0)
    crowd = np.array([[22.0, -5.0], [22.0, -5.4], [22.0, -4.6]])

    assert force_on(touching, crowd, obstacles=(WALL,))[0] > 0.0


def test_touching_robots_part_even_if_both_want_the_same_place() -> None:
    left, right = force_on((29.0, 0.0), [[29.6, 0.0]]), force_on((29.6, 0.0), [[29.0, 0.0]])

    assert left[0] - right[0] < -F_SAT


def test_the_intermember_force_ends_at_its_range() -> None:
    alone, far, near = (
        force_on((30.0, 0.0), others) for others in (None, [[30.0, 2 * RADIUS + 0.61]], [[30.0, 2 * RADIUS + 0.3]])
    )

    assert_allclose(far, alone)
    assert near[1] < -0.1 * F_SAT


def test_a_shape_narrower_than_the_robot_still_attracts() -> None:
    sliver = np.array([[-5.0, -0.2], [5.0, -0.2], [5.0, 0.2], [-5.0, 0.2]])

    assert force_on((0.0, 9.0), contour=sliver)[1] == pytest.approx(-F_SAT, rel=1e-3)
