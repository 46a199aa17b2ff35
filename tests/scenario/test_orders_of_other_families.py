"""What the operator of one family may order is refused by the others in a clear line."""

from __future__ import annotations

import numpy as np
import pytest

from bringup.families import BEHAVIORS
from bringup.scenario_file import load_any
from swarm_msgs_py.step_io import MissionInputs

SQUARE = np.array([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]])


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("coverage-ball", "shape refused: this swarm fills solids"),
        ("assembly-line", "shape refused: boats build the map of their scenario"),
    ],
)
def test_an_outline_is_refused_and_the_mission_goes_on(name: str, reason: str) -> None:
    scenario, origin = load_any(name, ())
    behavior = BEHAVIORS[scenario.family]
    mission = behavior.actors(behavior.resolve(scenario, origin)).mission()

    notices = [
        mission.step(MissionInputs(tick, tick * scenario.period_s, (), SQUARE if tick == 1 else None)).report.notice
        for tick in range(3)
    ]
    assert notices[1].startswith(reason)
    assert (notices[0], notices[2]) == ("", "")
