"""Robots that block each other where there is no room to pass exchange their goals; without that they never finish."""

from __future__ import annotations

import numpy as np
import pytest
from corridor import Corridor

from swarm_agent.config import AgentConfig
from swarm_agent.decision.config import DecisionConfig, SwapConfig
from swarm_agent.energy import EnergyConfig
from swarm_msgs_py.messages.bodies import Objective
from swarm_msgs_py.messages.report import Mode

WITHOUT, WITH = SwapConfig(after_s=None), SwapConfig()
LONG = 60.0  # seconds; with swaps they need less than 45


def settings(swap: SwapConfig, objective: Objective = Objective.TOTAL, energy: float = 1.0) -> AgentConfig:
    return AgentConfig(decision=DecisionConfig(swap=swap, objective=objective), energy=EnergyConfig(initial=energy))


def carried_to_each_others_place(config: AgentConfig) -> Corridor:
    """Return two robots that had settled for the goal next to them when somebody drove them to the other room."""
    corridor = Corridor([(5.0, 0.0), (-5.0, 0.0)], [(6.0, 0.0), (-6.0, 0.0)], [config, config])
    corridor.run(5.0)
    corridor.run(20.0, remote=np.array([[-0.5, 0.0], [0.5, 0.0]]))
    assert corridor.taken == [0, 1]
    assert (corridor.positions[:, 0] * [1, -1] < -3.0).all()
    return corridor


def behind_a_tired_one(swap: SwapConfig) -> Corridor:
    """Return two robots on their way into the corridor, the first of which may go only as far as the near goal.

    It has no energy left, so its meters count twice; it stops where it shuts in the other, whose goal is the far one.
    """
    corridor = Corridor(
        [(-4.0, 0.0), (-5.0, 0.0)], [(0.0, 0.0), (1.5, 0.0)], [settings(swap, energy=0.0), settings(swap)]
    )
    corridor.run(10.0)
    assert corridor.taken == [0, 1]
    return corridor


@pytest.mark.parametrize("objective", list(Objective))
def test_head_on_in_a_corridor_they_take_each_others_goal(objective: Objective) -> None:
    corridor = carried_to_each_others_place(settings(WITH, objective))

    assert corridor.finish(60.0)
    assert corridor.taken == [1, 0]
    assert corridor.overlaps == set()


def test_head_on_in_a_corridor_without_swaps_they_stand_there_forever() -> None:
    corridor = carried_to_each_others_place(settings(WITHOUT))

    assert not corridor.finish(LONG)
    assert [report.mode for report in corridor.reports] == [Mode.BLOCKED, Mode.BLOCKED]
    assert (np.abs(corridor.positions[:, 0]) < 2.0).all()


def test_a_parked_robot_that_shuts_in_another_goes_on_to_its_goal() -> None:
    corridor = behind_a_tired_one(WITH)

    assert corridor.finish(60.0)
    assert corridor.taken == [1, 0]
    assert corridor.overlaps == set()


def test_without_swaps_a_parked_robot_shuts_in_another_forever() -> None:
    corridor = behind_a_tired_one(WITHOUT)

    assert not corridor.finish(LONG)
    assert corridor.reports[1].mode is Mode.BLOCKED


def test_a_swap_survives_a_radio_that_loses_a_third_of_its_frames() -> None:
    config = settings(WITH)
    corridor = Corridor([(5.0, 0.0), (-5.0, 0.0)], [(6.0, 0.0), (-6.0, 0.0)], [config, config], loss=0.33)
    corridor.run(8.0)
    corridor.run(20.0, remote=np.array([[-0.5, 0.0], [0.5, 0.0]]))

    assert corridor.finish(60.0)
    assert corridor.overlaps == set()


def test_two_columns_head_on_in_a_corridor_all_turn_back() -> None:
    rooms = [(6.0, 0.6), (6.0, -0.6), (-6.0, 0.6), (-6.0, -0.6)]
    corridor = Corridor([(5.0, 0.5), (5.0, -0.5), (-5.0, 0.5), (-5.0, -0.5)], rooms, [settings(WITH)] * 4)
    corridor.run(8.0)
    corridor.run(21.0, remote=np.array([[-0.5, 0.0], [-0.5, 0.0], [0.5, 0.0], [0.5, 0.0]]))
    assert corridor.taken == [0, 1, 2, 3]

    assert corridor.finish(80.0)
    assert (corridor.positions[:, 0] * [1, 1, -1, -1] < -5.0).all()
    assert corridor.overlaps == set()
