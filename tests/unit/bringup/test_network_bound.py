"""The network of every actor bears the delay that the scenario's radio may cause."""

from __future__ import annotations

import pytest

from bringup.compose import ScenarioActors
from bringup.resolution import network_of, resolve
from bringup.scenario import Scenario
from bringup.scenario_file import Origin, load_scenario, parse_assignment
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import NodeId


def smoke(*settings: str) -> tuple[Scenario, Origin]:
    return load_scenario("smoke-4", tuple(parse_assignment(setting) for setting in settings))


@pytest.mark.parametrize(
    ("settings", "delay_max_s"),
    [
        ((), 1.0),
        (("sim.radio.delay_ticks_max=1",), 1.5),
        (("sim.radio.delay_ticks_max=1", "sim.radio.queue_s=1.0"), 2.0),  # a waiting frame takes a tick of its own, too
        (("sim.radio.budget_bps=1000.0", "sim.radio.queue_s=0.0"), 1.0),
        (("agent.network.delay_max_s=7.0",), 7.0),
    ],
)
def test_the_mesh_bears_the_latest_hello_of_the_radio(settings: tuple[str, ...], delay_max_s: float) -> None:
    scenario, origin = smoke(*settings)
    actors = ScenarioActors(resolve(scenario, origin))

    assert actors.agent_config(NodeId(0)).network.delay_max_s == pytest.approx(delay_max_s)
    assert network_of(actors.scenario) == actors.agent_config(NodeId(0)).network


def test_a_radio_too_slow_for_any_mesh_is_refused_in_one_line() -> None:
    scenario, origin = smoke("sim.radio.delay_ticks_max=200")

    with pytest.raises(
        ConfigError, match=r"sim\.radio: hellos can come 101 s late, .* lower queue_s or delay_ticks_max"
    ) as e:
        resolve(scenario, origin)
    assert "\n" not in str(e.value)
