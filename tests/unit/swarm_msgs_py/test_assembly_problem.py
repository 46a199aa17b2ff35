import json
from typing import Any

import pytest

from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.problem_file import parse_problem
from swarm_msgs_py.errors import AssemblyError

GOOD: dict[str, Any] = {
    "grid_size": [9, 9],
    "targets": [[4, 4], [5, 4]],
    "starts": [[1, 1], [9, 1], [1, 9]],
    "docks_genderless": [[0, 0, 0, 1], [0, 0, 1, 0], [1, 0, 0, 0]],
    "docks_gendered": [[0, 0, 0, 1], [0, 0, 2, 0], [1, 0, 0, 0]],
}


def parse(gender: Gender = Gender.GENDERLESS, **changes: Any) -> Any:
    return parse_problem(json.dumps({**GOOD, **changes}), "pool.json", gender)


def test_a_document_becomes_a_problem() -> None:
    problem = parse(Gender.OPPOSITE)

    assert (problem.boat_count, problem.target_count) == (3, 2)
    assert problem.layouts[1] == (0, 0, 2, 0)
    assert problem.contains((9, 9))
    assert not problem.contains((0, 9))


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"targets": [[4, 4], [6, 4]]}, "not connected: 2 pieces"),
        ({"targets": [[4, 4], [5, 5]]}, "not connected"),  # corners do not dock
        ({"targets": []}, "no targets"),
        ({"targets": [[4, 4], [4, 4]]}, "same cell"),
        ({"targets": [[9, 9], [10, 9]]}, "outside the grid"),
        ({"targets": [[3, 4], [4, 4], [5, 4], [6, 4]]}, "too few boats: 3 for 4 targets"),
        ({"starts": [[1, 1], [1, 1], [1, 9]]}, "overlap"),
        ({"starts": [[1, 1], [2, 2], [1, 9]]}, "boats 1 (1, 1) and 2 (2, 2) touch"),
        ({"starts": [[1, 1], [9, 1]]}, "2 starts and 3 docking layouts"),
        ({"docks_genderless": [[0, 0, 0, 1], [0, 0, 2, 0], [1, 0, 0, 0]]}, "docks of boat 2"),
        ({"docks_genderless": [[0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 0]]}, "only 1 boats have a docking mechanism"),
        ({"docks_genderless": [[0, 0, 1]]}, "four values"),
        ({"docks_genderless": [[0, 0, 0, True]]}, "whole number"),
        ({"grid_size": [9]}, "two whole numbers"),
        ({"grid_size": [0, 9]}, "at least one"),
        ({"starts": "here"}, "must be a list"),
        ({"dock_order": ["left", "right", "up", "down"]}, "ordered up, down, left, right"),
        ({"cell_origin": 1e300}, "whole number"),
        ({"extension_interval": 0}, "extension interval"),
    ],
)
def test_a_bad_document_is_refused_in_one_line_that_names_it(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(AssemblyError) as refusal:
        parse(**changes)

    text = str(refusal.value)
    assert text.startswith("pool.json: ")
    assert told in text
    assert "\n" not in text


@pytest.mark.parametrize("text", ["", "[1, 2]", "{", "[" * 5000])
def test_a_text_that_is_no_object_is_refused(text: str) -> None:
    with pytest.raises(AssemblyError, match=r"^pool\.json: "):
        parse_problem(text, "pool.json", Gender.GENDERLESS)


def test_a_missing_list_of_docks_is_named() -> None:
    record = {key: value for key, value in GOOD.items() if key != "docks_gendered"}

    with pytest.raises(AssemblyError, match="docks_gendered is missing"):
        parse_problem(json.dumps(record), "pool.json", Gender.OPPOSITE)
