"""The grid as one flat list of cells, with a border: what the step-by-step search of disassemblies works on."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_msgs_py.assembly.faces import OFFSETS, Cell
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem

BORDER = CLEARANCE
"""Cells around the grid, so that a neighborhood never leaves the list."""


class Lattice:
    """Numbers of the grid's cells.

    Parameters
    ----------
    problem : AssemblyProblem
        Its grid is used.
    obstacles : iterable of Cell
        Boats that never move; boats keep clear of them.

    Attributes
    ----------
    count : int
        Length of a list with one entry per cell, border included.
    moves : tuple of int
        What a step in the direction of each `Face` adds to a cell's number.
    near : tuple of int
        What leads from a cell to all cells that are too near to it for another group, itself included.
    is_closed : list of bool
        Cells that no boat may enter: the border, and what is too near to an obstacle.
    """

    def __init__(self, problem: AssemblyProblem, obstacles: Iterable[Cell] = ()) -> None:
        columns, rows = problem.size
        self._origin = problem.origin
        self._stride = rows + 2 * BORDER
        self.count = (columns + 2 * BORDER) * self._stride
        self.moves = tuple(dx * self._stride + dy for dx, dy in OFFSETS)
        reach = range(1 - CLEARANCE, CLEARANCE)
        self.near = tuple(dx * self._stride + dy for dx in reach for dy in reach)
        self.is_closed = [True] * self.count
        x0, y0 = self._origin
        for x in range(columns):
            first = self.number((x + x0, y0))
            self.is_closed[first : first + rows] = [False] * rows
        for obstacle in obstacles:
            for step in self.near:
                self.is_closed[self.number(obstacle) + step] = True

    def number(self, cell: Cell) -> int:
        """Return the number of a cell in the grid or its border."""
        return (cell[0] - self._origin[0] + BORDER) * self._stride + cell[1] - self._origin[1] + BORDER

    def cell(self, number: int) -> Cell:
        """Return the cell of a number."""
        column, row = divmod(number, self._stride)
        return column + self._origin[0] - BORDER, row + self._origin[1] - BORDER

    def distance(self, one: int, other: int) -> int:
        """Return the Manhattan distance of two cells, given by their numbers."""
        (x, y), (u, v) = self.cell(one), self.cell(other)
        return abs(x - u) + abs(y - v)
