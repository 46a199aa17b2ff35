"""What a robot has left, and how much its meters count."""

from __future__ import annotations

import pytest

from swarm_agent.decision.config import WeightConfig
from swarm_agent.decision.offering import weight_of
from swarm_agent.energy import EnergyConfig, EnergyStore
from swarm_msgs_py.messages.bodies import WEIGHT_MAX, WEIGHT_ONE
from swarm_msgs_py.messages.control import STOP, VelocityCommand

PERIOD = 0.5


def store_after(config: EnergyConfig, command: VelocityCommand, ticks: int) -> float:
    store = EnergyStore(config, PERIOD)
    for _ in range(ticks):
        store.spend(command)
    return store.left


def test_by_default_nothing_is_spent() -> None:
    assert store_after(EnergyConfig(), VelocityCommand(0.5, 0.0, 0.1), 10_000) == 1.0


def test_meters_and_seconds_are_spent() -> None:
    config = EnergyConfig(initial=0.9, per_meter=0.01, per_second=0.002)

    # 20 ticks: 10 s, at 0.5 m/s (3-4-5 triangle) 5 m.
    assert store_after(config, VelocityCommand(0.3, -0.4, 0.0), 20) == pytest.approx(0.9 - 0.05 - 0.02)


def test_at_rest_only_time_is_spent() -> None:
    config = EnergyConfig(per_meter=0.01, per_second=0.002)

    assert store_after(config, STOP, 20) == pytest.approx(0.98)


def test_an_empty_store_stays_empty() -> None:
    assert store_after(EnergyConfig(initial=0.1, per_second=0.1), STOP, 20) == 0.0


@pytest.mark.parametrize(
    ("config", "energy", "weight"),
    [
        (WeightConfig(), 1.0, 1.0),
        (WeightConfig(), 0.0, 2.0),
        (WeightConfig(energy_gain=0.5), 0.5, 1.25),
        (WeightConfig(energy_gain=0.0), 0.0, 1.0),
        (WeightConfig(priority=3.0), 0.5, 4.5),
    ],
)
def test_a_meter_counts_by_priority_and_by_what_is_missing_of_the_energy(
    config: WeightConfig, energy: float, weight: float
) -> None:
    assert weight_of(config, energy) == round(weight * WEIGHT_ONE)


def test_weights_fit_their_place_in_a_row() -> None:
    assert weight_of(WeightConfig(priority=100.0, energy_gain=100.0), 0.0) == WEIGHT_MAX
    assert 1 <= weight_of(WeightConfig(priority=0.01), 1.0) <= 3
