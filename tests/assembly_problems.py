"""Small assembly problems for tests."""

from __future__ import annotations

from collections.abc import Sequence

from swarm_msgs_py.assembly.faces import Cell, Gender, Layout
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.assembly.problem_file import nearest_to_centroid

ALL_SIDES: Layout = (1, 1, 1, 1)


def problem_of(
    targets: Sequence[Cell],
    layouts: Sequence[Layout],
    *,
    gender: Gender = Gender.GENDERLESS,
    starts: Sequence[Cell] | None = None,
    size: Cell = (30, 30),
) -> AssemblyProblem:
    """Return a problem; without `starts`, boats stand in the lowest row, three cells apart."""
    return AssemblyProblem(
        name="test",
        origin=(1, 1),
        size=size,
        targets=tuple(targets),
        starts=tuple(starts) if starts is not None else tuple((1 + 3 * n, 1) for n in range(len(layouts))),
        layouts=tuple(layouts),
        gender=gender,
        center=nearest_to_centroid(tuple(targets)),
    )


def block(columns: int, rows: int, corner: Cell = (12, 12)) -> list[Cell]:
    """Return the cells of a filled rectangle."""
    return [(corner[0] + x, corner[1] + y) for x in range(columns) for y in range(rows)]
