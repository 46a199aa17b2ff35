"""What a scenario leaves open of ranging and of what the robots believe of it, each follows from the other."""

from __future__ import annotations

import pytest

from bringup.compose import ScenarioActors
from bringup.resolution import resolve
from bringup.scenario_file import Override, load_scenario
from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_msgs_py.types import NodeId
from swarm_sim.config import RangingConfig, RangingModel


def settings_of(**overrides: str | float) -> tuple[RangingConfig, LpsConfig]:
    """Return what the world and the robots of a scenario are run with; dots of the keys written as two underscores."""
    told = tuple(Override("test", key.replace("__", "."), value) for key, value in overrides.items())
    actors = ScenarioActors(resolve(*load_scenario("smoke-4", told)))
    return actors.world_config.ranging, actors.agent_config(NodeId(0)).lps


@pytest.mark.parametrize("mode", LpsMode)
def test_the_world_ranges_as_the_robots_expect_it(mode: LpsMode) -> None:
    ranging, lps = settings_of(agent__lps__mode=mode.value)

    assert lps.mode is mode
    assert ranging.model is (RangingModel.POSITION if mode is LpsMode.LITERAL else RangingModel.RANGE)


@pytest.mark.parametrize("model", RangingModel)
@pytest.mark.parametrize("mode", [LpsMode.LITERAL, LpsMode.FIXES])
def test_a_world_that_is_told_how_to_range_does_so(model: RangingModel, mode: LpsMode) -> None:
    ranging, _ = settings_of(agent__lps__mode=mode.value, sim__ranging__model=model.value)

    assert ranging.model is model


def test_the_world_ranges_as_often_as_the_robots_localize_unless_told_otherwise() -> None:
    assert settings_of(agent__lps__period_s=3.0)[0].period_s == 3.0
    assert settings_of(agent__lps__period_s=3.0, sim__ranging__period_s=1.0)[0].period_s == 1.0


def test_the_robots_know_how_noisy_the_world_s_ranges_are() -> None:
    _, lps = settings_of(sim__ranging__sigma_m=0.7)

    assert (lps.range_sigma, lps.position_noise_sigma) == (0.7, 0.7)


def test_a_filter_may_be_told_another_noise_than_the_world_s() -> None:
    ranging, lps = settings_of(
        sim__ranging__sigma_m=0.7, agent__lps__range_sigma_m=1.5, agent__lps__position_noise_sigma_m=2.5
    )

    assert (ranging.sigma_m, lps.range_sigma, lps.position_noise_sigma) == (0.7, 1.5, 2.5)


def test_in_a_world_without_noise_the_filters_reckon_with_a_little() -> None:
    assert 0.0 < settings_of(sim__ranging__sigma_m=0.0)[1].range_sigma <= 0.05
