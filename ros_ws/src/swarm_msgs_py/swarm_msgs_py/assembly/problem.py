"""What is to be built, with which boats, from where: checked once, then trusted."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from swarm_msgs_py.assembly.faces import OFFSETS, Cell, Gender, Layout
from swarm_msgs_py.errors import AssemblyError

CLEARANCE = 2
"""Least Chebyshev distance of cells of groups that are not docking partners: one free cell, diagonals included."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AssemblyProblem:
    """A structure, and the boats that are to build it.

    Attributes
    ----------
    name : str
        What to call it in errors and reports.
    origin, size : Cell
        Lower left cell of the grid; number of columns and rows.
    targets : tuple of Cell
        Cells of the structure; their order numbers the targets.
    starts : tuple of Cell
        Where each boat starts; their order numbers the boats.
    layouts : tuple of Layout
        Mechanisms of each boat, as it is turned at the start.
    gender : Gender
        Which mechanisms join.
    center : Cell
        Center of the extension (stage III).
    interval : int
        Free cells that the extension leaves between boats, I.
    obstacles : tuple of Cell
        Cells that are taken for good, by dead boats for example.
    is_midway : bool
        The boats are in the middle of an assembly: some stand side by side, docked or not.
    """

    name: str
    origin: Cell
    size: Cell
    targets: tuple[Cell, ...]
    starts: tuple[Cell, ...]
    layouts: tuple[Layout, ...]
    gender: Gender
    center: Cell
    interval: int = 3
    obstacles: tuple[Cell, ...] = ()
    is_midway: bool = False

    @property
    def boat_count(self) -> int:
        """N, how many boats there are."""
        return len(self.starts)

    @property
    def target_count(self) -> int:
        """M, how many cells the structure has."""
        return len(self.targets)

    def contains(self, cell: Cell) -> bool:
        """Return whether a cell lies in the grid."""
        return all(0 <= at - low < count for at, low, count in zip(cell, self.origin, self.size, strict=True))

    def travel(self, boat: int, target: int) -> int:
        """Return the Manhattan distance from a boat's start to a target [cells]."""
        return manhattan(self.starts[boat], self.targets[target])

    def __post_init__(self) -> None:
        """Refuse what no boats could build.

        Raises
        ------
        AssemblyError
            One line that names the problem, what is wrong with it and where, and what to do.
        """
        _check_grid(self)
        _check_boats(self)
        _check_structure(self)


def manhattan(one: Cell, other: Cell) -> int:
    """Return how many steps lead from one cell to the other."""
    return abs(one[0] - other[0]) + abs(one[1] - other[1])


def chebyshev(one: Cell, other: Cell) -> int:
    """Return the larger of the distances along the two axes."""
    return max(abs(one[0] - other[0]), abs(one[1] - other[1]))


def neighbors(cell: Cell) -> tuple[Cell, ...]:
    """Return the four cells that share a side with `cell`, in the order of `Face`."""
    x, y = cell
    return tuple((x + dx, y + dy) for dx, dy in OFFSETS)


def pieces(cells: Iterable[Cell]) -> list[set[Cell]]:
    """Return the edge-connected pieces of a set of cells, in the order of their least cell."""
    left = set(cells)
    found = []
    for first in sorted(left):
        if first not in left:
            continue
        left.remove(first)
        piece, border = {first}, [first]
        while border:
            fresh = [cell for cell in neighbors(border.pop()) if cell in left]
            left.difference_update(fresh)
            piece.update(fresh)
            border.extend(fresh)
        found.append(piece)
    return found


def moved(problem: AssemblyProblem, origin: Cell, size: Cell) -> AssemblyProblem:
    """Return the same problem on another grid."""
    return replace(problem, origin=origin, size=size)


def _check_grid(problem: AssemblyProblem) -> None:
    where = f"{problem.name}: "
    if min(problem.size) < 1:
        raise AssemblyError(f"{where}the grid has {problem.size[0]} x {problem.size[1]} cells; it needs at least one")
    if problem.interval < CLEARANCE - 1:
        raise AssemblyError(f"{where}extension interval is {problem.interval}; give at least {CLEARANCE - 1} free cell")
    for what, cells in (("target", problem.targets), ("start", problem.starts), ("center", (problem.center,))):
        for number, cell in enumerate(cells):
            if not problem.contains(cell):
                last = tuple(low + count - 1 for low, count in zip(problem.origin, problem.size, strict=True))
                raise AssemblyError(
                    f"{where}{what} {number + 1} at {cell} is outside the grid {problem.origin} to {last};"
                    " move it or enlarge the grid"
                )


def _check_boats(problem: AssemblyProblem) -> None:
    where = f"{problem.name}: "
    if len(problem.layouts) != problem.boat_count:
        raise AssemblyError(
            f"{where}{problem.boat_count} starts and {len(problem.layouts)} docking layouts; give one layout per boat"
        )
    allowed = problem.gender.types
    for boat, layout in enumerate(problem.layouts):
        if len(layout) != len(OFFSETS) or any(side not in allowed for side in layout):
            raise AssemblyError(
                f"{where}docks of boat {boat + 1} are {list(layout)}; {problem.gender.value} boats have four values out"
                f" of {', '.join(map(str, allowed))}"
            )
    order = sorted(range(problem.boat_count), key=lambda boat: problem.starts[boat])
    for place, boat in enumerate(order):
        for other in order[place + 1 :]:
            if problem.starts[other][0] - problem.starts[boat][0] >= CLEARANCE:
                break
            gap = chebyshev(problem.starts[boat], problem.starts[other])
            if gap == 0 or (gap < CLEARANCE and not problem.is_midway):
                first, second = sorted((boat, other))
                what = "overlap" if problem.starts[boat] == problem.starts[other] else "touch"
                raise AssemblyError(
                    f"{where}starts of boats {first + 1} {problem.starts[first]} and {second + 1}"
                    f" {problem.starts[second]} {what}; leave at least one free cell between them"
                )


def _check_structure(problem: AssemblyProblem) -> None:
    where = f"{problem.name}: "
    count = problem.target_count
    if count == 0:
        raise AssemblyError(f"{where}no targets; give at least one cell to fill")
    seen: dict[Cell, int] = {}
    for number, cell in enumerate(problem.targets):
        if cell in seen:
            raise AssemblyError(f"{where}targets {seen[cell] + 1} and {number + 1} are the same cell {cell}; drop one")
        seen[cell] = number
    parts = pieces(problem.targets)
    if len(parts) > 1:
        apart = min(sorted(parts, key=len)[0])
        raise AssemblyError(
            f"{where}targets are not connected: {len(parts)} pieces, one of them around {apart};"
            " every target needs a neighbor above, below, left or right"
        )
    if problem.boat_count < count and not problem.is_midway:
        raise AssemblyError(
            f"{where}too few boats: {problem.boat_count} for {count} targets; add {count - problem.boat_count} boats"
        )
    able = sum(any(layout) for layout in problem.layouts)
    if count > 1 and able < count and not problem.is_midway:
        raise AssemblyError(
            f"{where}only {able} boats have a docking mechanism, and {count} targets need one each;"
            f" equip {count - able} more"
        )
