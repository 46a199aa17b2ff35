"""What the mission computer hears of boats that find their ways by themselves: where each is, and since when."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_msgs_py.assembly.boat_frames import BoatFrame, Phase
from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem


class FoundWays:
    """Listens to what boats tell each other.

    Parameters
    ----------
    problem : AssemblyProblem
    plan : AssemblyPlan

    Attributes
    ----------
    cells : list of Cell
        Where each boat was last.
    """

    def __init__(self, problem: AssemblyProblem, plan: AssemblyPlan) -> None:
        self.cells: list[Cell] = list(problem.starts)
        self._next: list[Cell] = list(problem.starts)
        self._targets = dict(zip(plan.dispatch.boats, problem.targets, strict=True))
        self._moved_at = 0

    def hear(self, tick: int, words: Iterable[BoatFrame]) -> None:
        """Take in what was said in a tick; boats without a target say nothing."""
        for word in words:
            if word.boat not in self._targets:
                continue
            x, y = self._targets[word.boat]
            cell = (x + word.shift[0], y + word.shift[1])
            if word.phase is Phase.LOOK and cell != self.cells[word.boat]:
                self._moved_at = tick
                self.cells[word.boat] = cell
            if word.phase is not Phase.LOOK:
                dx, dy = word.move.offset
                self._next[word.boat] = (cell[0] + dx, cell[1] + dy)

    def next_of(self, boat: int) -> Cell:
        """Return where a boat that fell silent may be instead."""
        return self._next[boat]

    def are_stalled(self, tick: int, patience_ticks: int) -> bool:
        """Return whether nobody has moved for so long."""
        return tick - self._moved_at > patience_ticks
