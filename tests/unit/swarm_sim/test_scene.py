from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from arena import make_robot, make_scene, rectangle

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import MISSION
from swarm_sim.scene import Scene, check_scene

BLOCK = rectangle(2.0, 2.0, 4.0, 4.0)
BOW_TIE = np.array([(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)])


def test_a_sound_scene_passes() -> None:
    check_scene(make_scene([make_robot(0, (0.0, 0.0)), make_robot(4, (1.0, 1.0), THESIS_TYPES[2])], [BLOCK]))


def test_a_hair_s_breadth_is_enough() -> None:
    check_scene(make_scene([make_robot(0, (1.849, 3.0)), make_robot(1, (1.548, 3.0))], [BLOCK]))


BAD: dict[str, tuple[Callable[[], Scene], str]] = {
    "no robot": (lambda: make_scene([]), "no robot"),
    "same id twice": (lambda: make_scene([make_robot(1, (0.0, 0.0)), make_robot(1, (2.0, 0.0))]), "unique"),
    "ids not ascending": (lambda: make_scene([make_robot(1, (0.0, 0.0)), make_robot(0, (2.0, 0.0))]), "ascending"),
    "address of the mission computer": (lambda: make_scene([make_robot(MISSION, (0.0, 0.0))]), "ids must be"),
    "outside": (lambda: make_scene([make_robot(0, (10.5, 0.0))]), r"r00 starts at \(10.5, 0\), outside the bounds"),
    "not a number": (lambda: make_scene([make_robot(0, (np.nan, 0.0))]), "not a number"),
    "in an obstacle": (lambda: make_scene([make_robot(0, (3.0, 3.0))], [BLOCK]), "in or against obstacle 0"),
    "against an obstacle": (lambda: make_scene([make_robot(0, (1.9, 3.0))], [BLOCK]), "at least 0.15 m away"),
    "overlap": (
        lambda: make_scene([make_robot(0, (0.0, 0.0)), make_robot(7, (0.5, 0.0), THESIS_TYPES[2])]),
        r"r00 and r07 overlap at the start \(0.500 m apart, they need 0.65 m\)",
    ),
    "obstacle crosses itself": (lambda: make_scene(obstacles=[BOW_TIE + 3.0]), "obstacle 0 is not a simple polygon"),
    "obstacle without area": (
        lambda: make_scene(obstacles=[BLOCK, np.array([(5.0, 5.0), (6.0, 6.0), (7.0, 7.0)])]),
        "obstacle 1 is not a simple polygon",
    ),
    "obstacle of two corners": (lambda: make_scene(obstacles=[BLOCK[:2]]), "at least 3 corners"),
    "obstacle with nan": (lambda: make_scene(obstacles=[BLOCK * np.nan]), "finite"),
    "antenna in obstacle": (lambda: make_scene(obstacles=[BLOCK], mission_position=(3.0, 3.0)), "antenna"),
    "empty bounds": (lambda: replace(make_scene(), bounds=(1.0, 0.0, 1.0, 5.0)), "x_min < x_max"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_scene_that_cannot_start_is_refused_in_one_clear_line(case: str) -> None:
    build, message = BAD[case]

    with pytest.raises(ConfigError, match=message) as caught:
        check_scene(build())

    assert "\n" not in str(caught.value)
