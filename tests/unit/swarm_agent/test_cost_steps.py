"""How finely robots tell each other how far they have to go."""

from __future__ import annotations

import numpy as np
import pytest
from builders import make_plan

from bringup.resolution import resolve
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_agent.decision.path_costs import PathCosts
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.messages.bodies import UNREACHABLE
from swarm_msgs_py.robots import THESIS_TYPES

PLAN = make_plan(np.array([[1.0, 0.0], [1.004, 0.0], [0.0, 3.0]]))


@pytest.mark.parametrize(("step_m", "costs"), [(0.01, [100, 100, 300]), (0.001, [1000, 1004, 3000])])
def test_costs_are_whole_steps(step_m: float, costs: list[int]) -> None:
    paths = PathCosts(THESIS_TYPES[0], PlanningConfig(), step_m)

    assert paths.of(0, PLAN, np.zeros(2)).tolist() == costs
    assert paths.steps(0.5) == round(0.5 / step_m)


def test_what_is_too_long_to_be_told_is_as_long_as_can_be() -> None:
    paths = PathCosts(THESIS_TYPES[0], PlanningConfig(), 1e-4)

    assert paths.of(0, make_plan(np.array([[20.0, 0.0]])), np.zeros(2)).tolist() == [UNREACHABLE - 1]


def test_an_arena_that_is_too_large_for_the_steps_is_refused() -> None:
    with pytest.raises(ConfigError, match="path lengths up to 7 m"):
        resolve(*load_scenario("smoke-4", (parse_assignment("agent.decision.cost_step_m=0.0001"),)))
