"""Names of nodes in alerts: short, and true."""

from __future__ import annotations

import pytest

from bringup.labels import LISTED_MAX, distance_text, first_few, node_list
from swarm_msgs_py.types import MISSION, NodeId

CASES = {
    "none": ((), ""),
    "few": ((1, 3, 8), "r01, r03, r08"),
    "as many as are listed": (range(LISTED_MAX), ", ".join(f"r{number:02d}" for number in range(LISTED_MAX))),
    "many dealt out": (range(1, 50, 2), "r01 to r49 in steps of 2 (25 robots)"),
    "many in a row": (range(50), "r00 to r49 (50 robots)"),
    "many with a gap": (
        (*range(12), 13),
        "r00, r01, r02, r03, r04, r05, r06, r07, r08, r09, r10, r11, r13",
    ),
    "mission computer": ((2, MISSION), "r02, mission computer"),
}


@pytest.mark.parametrize("case", CASES)
def test_nodes_are_named_as_short_as_is_exact(case: str) -> None:
    nodes, expected = CASES[case]

    assert node_list([NodeId(number) for number in nodes]) == expected


def test_the_first_few_of_many_names_stand_for_all() -> None:
    assert first_few([]) == ""
    assert first_few(["a", "b", "c", "d"]) == "a, b, c, d"
    assert first_few(["a", "b", "c", "d", "e"]) == "a, b, c, d, ..."


def test_small_distances_are_told_in_millimeters() -> None:
    assert [distance_text(value) for value in (None, 0.0004, 0.25)] == ["-", "0.4 mm", "0.250 m"]
