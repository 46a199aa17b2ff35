"""One robot under forces: what it hears, what it commands, when it rests."""

from __future__ import annotations

import numpy as np
import pytest
from builders import PERIOD, SQUARE, make_presence
from numpy.testing import assert_allclose, assert_array_equal

from swarm_agent.forces.config import ForceConfig, ForceLawName
from swarm_agent.forces.force_drive import ForceDrive
from swarm_agent.forces.force_law import Others
from swarm_agent.forces.registry import law_for
from swarm_agent.forces.strategy import ForceStrategy
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Presence
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

RADII = {kind.type: kind.coverage_radius_m for kind in THESIS_TYPES}
LAWS = list(ForceLawName)


def make_strategy(law: ForceLawName = ForceLawName.LITERAL, period: float = PERIOD) -> ForceStrategy:
    return ForceStrategy(law, ForceConfig(), PlanningConfig(), THESIS_TYPES[0], RADII, period)


def velocity_at(
    strategy: ForceStrategy, x: float, y: float, heard: dict[int, Presence] | None = None, sigma: float = 0.0
) -> FloatArray:
    neighbors = {NodeId(node): presence for node, presence in (heard or {}).items()}
    return strategy.step(7, np.array([x, y]), neighbors, SQUARE, (), sigma)


@pytest.mark.parametrize("law", LAWS)
def test_far_outside_a_robot_drives_to_the_shape_at_full_speed(law: ForceLawName) -> None:
    strategy = make_strategy(law)

    assert_allclose(velocity_at(strategy, 30.0, 0.0), [-0.5, 0.0], atol=1e-6)
    assert not strategy.is_at_rest


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("period", [0.05, 0.5, 1.0])
def test_no_command_is_faster_than_the_limit(law: ForceLawName, period: float) -> None:
    strategy = make_strategy(law, period)
    crowd = {node: make_presence(5.0 + 0.1 * node, 0.05 * node, tick=7) for node in range(8)}

    assert np.linalg.norm(velocity_at(strategy, 5.3, 0.2, crowd)) <= 0.5 + 1e-12


@pytest.mark.parametrize("law", LAWS)
def test_in_the_middle_of_the_shape_a_robot_alone_rests(law: ForceLawName) -> None:
    strategy = make_strategy(law)

    assert_array_equal(velocity_at(strategy, 0.0, 0.0), [0.0, 0.0])
    assert strategy.is_at_rest


def test_a_robot_that_knows_its_place_badly_rests_sooner() -> None:
    sure, unsure = make_strategy(ForceLawName.SHARING), make_strategy(ForceLawName.SHARING)

    velocity_at(sure, 0.3, 0.0)
    velocity_at(unsure, 0.3, 0.0, sigma=0.6)

    assert unsure.is_at_rest
    assert not sure.is_at_rest


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("sigma", [0.6, 2.0, 50.0])
def test_however_badly_a_robot_knows_its_place_it_drives_to_a_shape_far_away(law: ForceLawName, sigma: float) -> None:
    strategy = make_strategy(law)

    velocity_at(strategy, 0.0, 0.0, sigma=sigma)
    assert strategy.is_at_rest
    assert velocity_at(strategy, 30.0, 0.0, sigma=sigma)[0] < -0.4


def test_a_resting_robot_starts_again_only_under_a_clear_force() -> None:
    strategy, fresh = make_strategy(ForceLawName.SHARING), make_strategy(ForceLawName.SHARING)
    velocity_at(strategy, 0.0, 0.0)

    assert not velocity_at(strategy, 0.3, 0.0).any()  # who moves so slowly does not stop, but does not begin either
    assert velocity_at(fresh, 0.3, 0.0).any()
    assert velocity_at(strategy, 3.0, 0.0).any()


@pytest.mark.parametrize("law", LAWS)
def test_who_cannot_be_in_the_way_does_not_count(law: ForceLawName) -> None:
    alone = velocity_at(make_strategy(law), 30.0, 0.0)
    heard = {
        int(MISSION): make_presence(29.5, 0.3, robot_type=0, tick=7),
        3: make_presence(29.5, -0.3, sigma=SIGMA_UNKNOWN, tick=7),
    }

    assert_array_equal(velocity_at(make_strategy(law), 30.0, 0.0, heard), alone)


def test_neighbors_are_taken_to_be_where_they_have_got_to_since_their_hello() -> None:
    upward = np.array([0.0, 1.0])
    now = {3: make_presence(1.0, 2.0, tick=7, velocity=upward)}
    earlier = {3: make_presence(1.0, 0.0, tick=3, velocity=upward)}  # four ticks of 0.5 s ago

    assert_allclose(velocity_at(make_strategy(), 0.0, 0.0, earlier), velocity_at(make_strategy(), 0.0, 0.0, now))


def test_larger_neighbors_are_kept_farther_away_from() -> None:
    pushes = [
        velocity_at(make_strategy(), 0.0, 0.0, {3: make_presence(1.8, 0.0, robot_type=kind, tick=7)})[0]
        for kind in (1, 2, 3)
    ]

    assert pushes[2] < pushes[1] < pushes[0] < 0.0


def test_what_is_commanded_is_the_mean_of_a_motion_in_short_steps() -> None:
    # At a gap of 0.1 m the first force alone would drive 0.25 m in a tick; the robot foresees that it is over sooner.
    config = ForceConfig()
    law = law_for(ForceLawName.LITERAL, config, SQUARE, (), PlanningConfig())
    position, radius = np.array([[-0.4, 0.0]]), np.array([0.15])
    between = Others(np.array([[0.0, 0.0], [-0.85, 0.0]]), np.array([0.15, 0.15]), np.ones((1, 2), dtype=np.bool_))

    foreseen = ForceDrive(config, PERIOD).step(law, position, radius, between, np.zeros((2, 2)))
    blind = ForceDrive(ForceConfig(substep_s=0.1), 0.1).step(law, position, radius, between, np.zeros((2, 2)))

    assert np.abs(blind).max() == pytest.approx(0.5, rel=0.01)
    assert np.abs(foreseen).max() < 0.3


def test_equal_shapes_and_settings_share_one_law() -> None:
    config = ForceConfig()

    one, same, other = (
        law_for(ForceLawName.SHARING, config, shape, (), PlanningConfig())
        for shape in (SQUARE, SQUARE.copy(), SQUARE + 1.0)
    )
    assert one is same
    assert one is not other
    assert one is not law_for(ForceLawName.LITERAL, config, SQUARE, (), PlanningConfig())


def test_rest_without_hysteresis_is_refused() -> None:
    with pytest.raises(ConfigError, match="wake_m_s must be > rest_m_s"):
        ForceConfig(rest_m_s=0.1, wake_m_s=0.1)
