"""The largest part that can be built: as large as trying everything finds, with docked groups that stay rigid."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, permutations, product

import numpy as np
import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.constraint_model import SolverLimits
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.largest_part import BuildablePart, largest_part
from mission_computer.assembly.structure import Structure
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Cell, Gender, Layout, distinct_turns, turned
from swarm_msgs_py.assembly.problem import AssemblyProblem

LIMITS = SolverLimits(1, 5.0)
SHAPES: dict[str, list[Cell]] = {
    "square": block(2, 2),
    "T": [(12, 13), (13, 13), (14, 13), (13, 12)],
    "line": block(4, 1),
}


def problem(cells: list[Cell], layouts: list[Layout], gender: Gender = Gender.GENDERLESS) -> AssemblyProblem:
    able = problem_of(cells, [ALL_SIDES] * len(layouts), gender=gender)
    return replace(able, layouts=tuple(layouts), is_midway=True)


def holds(cells: tuple[Cell, ...], layouts: tuple[Layout, ...], gender: Gender) -> bool:
    """Return whether boats on some cells can be put together pairwise along straight lines."""
    structure = Structure(cells)
    return CutForest(structure, docked_contacts(cells, layouts, gender)).is_separable(structure.whole)


def largest_by_trying(given: AssemblyProblem) -> int:
    boats = range(given.boat_count)
    for size in range(given.target_count, 1, -1):
        for targets, crew in product(combinations(given.targets, size), permutations(boats, size)):
            choices = [[turned(given.layouts[b], n) for n in distinct_turns(given.layouts[b])] for b in crew]
            if any(holds(targets, layouts, given.gender) for layouts in product(*choices)):
                return size
    return 1


def is_sound(given: AssemblyProblem, part: BuildablePart) -> bool:
    cells = tuple(given.targets[target] for target in part.targets)
    return holds(cells, part.dispatch.layouts(given), given.gender) or len(cells) == 1


@pytest.mark.parametrize("gender", Gender)
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(2))
def test_no_part_that_trying_everything_finds_is_larger(shape: str, gender: Gender, seed: int) -> None:
    rng = np.random.default_rng(seed)
    sides = [0, 0, *gender.types]
    layouts = [tuple(int(x) for x in rng.choice(sides, 4)) for _ in range(4)]
    given = problem(SHAPES[shape], layouts, gender)
    if not any(any(layout) for layout in layouts):
        return

    part = largest_part(given, (), (), (), LIMITS)

    assert part is not None
    assert len(part.targets) == part.bound == largest_by_trying(given)
    assert is_sound(given, part)


def test_a_docked_group_goes_where_it_fits_and_is_not_taken_apart() -> None:
    """A pair that is docked side by side can be the upper or the lower two of a square, and nothing in a column."""
    square = replace(problem(SHAPES["square"], [ALL_SIDES] * 4), starts=((5, 5), (6, 5), (20, 5), (20, 12)))
    column = replace(square, targets=tuple(block(1, 4)))

    whole = largest_part(square, ((0, 1),), (), (), LIMITS)
    without = largest_part(column, ((0, 1),), (), (), LIMITS)

    assert whole is not None
    assert without is not None
    place = dict(zip(whole.dispatch.boats, whole.targets, strict=True))
    (x, y), (u, v) = (square.targets[place[boat]] for boat in (0, 1))
    assert (u - x, v - y) == (1, 0)
    assert (len(whole.targets), whole.groups) == (4, ((0, 1),))
    assert sorted(without.dispatch.boats) == [2, 3]
    assert without.bound == 2


def test_a_part_that_is_forbidden_is_not_found_again() -> None:
    given = problem(SHAPES["square"], [*[ALL_SIDES] * 3, (0, 0, 0, 0)])
    found: list[BuildablePart] = []
    for _ in range(6):
        part = largest_part(given, (), (), found, LIMITS)
        assert part is not None
        found.append(part)

    assert len({part.targets for part in found}) == len(found)
    assert [len(part.targets) for part in found] == sorted((len(part.targets) for part in found), reverse=True)


def test_suspects_are_used_only_where_there_is_nobody_else() -> None:
    given = problem(SHAPES["square"], [ALL_SIDES] * 5)

    part = largest_part(given, (), {1}, (), LIMITS)

    assert part is not None
    assert sorted(part.dispatch.boats) == [0, 2, 3, 4]
