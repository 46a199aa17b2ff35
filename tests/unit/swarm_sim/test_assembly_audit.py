import numpy as np
import pytest
from assembly_problems import ALL_SIDES, problem_of

from swarm_msgs_py.assembly.plan import Dispatch
from swarm_sim.metrics.assembly import AssemblyAudit, audit_assembly

LINE = [(5, 5), (6, 5), (7, 5)]
STARTS = [(2, 5), (6, 2), (10, 5)]
EVERYBODY = Dispatch((0, 1, 2), (0, 0, 0))


def audit(*rows: list[tuple[int, int]], layouts=(ALL_SIDES,) * 3, dispatch=EVERYBODY, targets=LINE) -> AssemblyAudit:
    problem = problem_of(targets, layouts, starts=STARTS, size=(12, 12))
    return audit_assembly(problem, dispatch, np.array(rows, dtype=np.int64))


LEGAL = (
    STARTS,
    [(3, 5), (6, 3), (9, 5)],
    [(3, 5), (6, 4), (9, 5)],
    [(4, 5), (6, 5), (9, 5)],
    [(5, 5), (6, 5), (9, 5)],
    [(5, 5), (6, 5), (8, 5)],
    [(5, 5), (6, 5), (7, 5)],
)


def test_a_legal_assembly_has_no_violations() -> None:
    result = audit(*LEGAL)

    assert result.violations == ()
    assert (result.steps, result.components, result.docked_contacts, result.dockings) == (6, 1, 2, 2)


@pytest.mark.parametrize(
    ("step", "boat", "cell", "told"),
    [
        (1, 0, (4, 5), "2 moves at once"),
        (4, 2, (5, 5), "both at"),
        (6, 2, (8, 5), "ends at (8, 5)"),
        (6, 0, (4, 5), "were docked and came apart"),
        (5, 2, (7, 6), "3 moves at once"),
    ],
)
def test_a_broken_rule_is_told(step: int, boat: int, cell: tuple[int, int], told: str) -> None:
    rows = [list(row) for row in LEGAL]
    rows[step][boat] = cell

    assert any(told in line for line in audit(*rows).violations)


def test_three_groups_that_dock_at_once_are_told() -> None:
    rows = (STARTS, [(3, 5), (6, 3), (9, 5)], [(4, 5), (6, 4), (8, 5)], [(5, 5), (6, 5), (7, 5)])

    assert any("3 groups dock at once" in line for line in audit(*rows).violations)


def test_a_dock_where_the_structure_has_none_is_told() -> None:
    rows = [list(row) for row in LEGAL]
    rows[2] = [(4, 4), (6, 4), (9, 5)]
    rows[3] = [(5, 4), (6, 4), (9, 5)]  # targets 0 and 1 side by side, as wanted
    rows[3][0], rows[3][1] = (6, 3), (6, 4)  # one below the other, as not wanted

    assert any("dock where the structure has no such neighbors" in line for line in audit(*rows).violations)


def test_sides_that_meet_without_mechanisms_do_not_dock() -> None:
    bare = ((1, 1, 0, 0),) * 3

    result = audit(*LEGAL, layouts=bare)

    assert result.components == 3
    assert any("3 pieces that are not docked" in line for line in result.violations)


def test_groups_that_pass_too_closely_are_told() -> None:
    rows = [list(row) for row in LEGAL]
    rows[4] = [(5, 5), (6, 5), (8, 6)]
    rows[3] = [(4, 5), (6, 5), (8, 6)]
    rows[2] = [(3, 5), (6, 4), (8, 6)]
    rows[1] = [(3, 5), (6, 3), (9, 6)]
    rows[5] = [(5, 5), (6, 5), (8, 5)]
    rows.insert(4, [(4, 4), (6, 5), (8, 6)])

    assert audit(*rows).violations


def test_swapped_cells_are_told() -> None:
    problem = problem_of([(5, 5)], [ALL_SIDES, ALL_SIDES], starts=[(5, 7), (5, 5)], size=(12, 12))
    rows = np.array([[(5, 7), (5, 5)], [(5, 6), (5, 5)], [(5, 5), (5, 6)]])

    told = audit_assembly(problem, Dispatch((0,), (0,)), rows).violations

    assert any("swap cells" in line for line in told)
    assert any("boat 1 moves, and has no target" in line for line in told)
