"""Timed guideposts, followed without a common clock: a group steps on when those that must go first have gone.

The steps of a plan say who passes a place before whom. That order is kept, not the clock: a boat may be late by any
time, and everybody who would meet it waits. Boats tell the steps that they have reached.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from swarm_msgs_py.assembly.boat_frames import Move
from swarm_msgs_py.assembly.plan import AssemblyTree, Dispatch, TimedPaths
from swarm_msgs_py.assembly.precedence import crews_of, needed_steps, turning_step
from swarm_msgs_py.assembly.problem import AssemblyProblem


class TimedFollower:
    """Follows the timed path of one boat.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    tree : AssemblyTree
        Order in which groups join.
    paths : TimedPaths
    boat : int
        Whose path it is; a boat with a target.
    """

    def __init__(
        self, problem: AssemblyProblem, dispatch: Dispatch, tree: AssemblyTree, paths: TimedPaths, boat: int
    ) -> None:
        self._cells = paths.cells
        self._boat = boat
        self.steps_done = 0
        self._crews = crews_of(problem, dispatch, tree, paths, boat)
        self.turning_step = turning_step(problem, self._crews, paths.cells, boat)
        movers = np.array(sorted(dispatch.boats))
        self._waits = [needed_steps(self._crews, paths.cells, movers, boat, step) for step in range(paths.steps)]

    @property
    def crew(self) -> tuple[int, ...]:
        """Boats of the docked group that it is part of, ascending; they step together."""
        return self._crews[self.steps_done]

    @property
    def is_docking(self) -> bool:
        """Whether its group meets its partner in the next step."""
        return not self.is_done and self._crews[self.steps_done + 1] != self.crew

    @property
    def is_done(self) -> bool:
        """Whether the whole path lies behind it."""
        return self.steps_done == len(self._waits)

    def may_go(self, reached: Mapping[int, int]) -> bool:
        """Return whether its group may make the next step.

        Parameters
        ----------
        reached : mapping
            Last step that each boat is known to have reached; who is not in it has not left its start.
        """
        if self.is_done:
            return False
        return all(reached.get(boat, 0) >= step for boat, step in self._waits[self.steps_done].items())

    def go(self) -> Move:
        """Return the next move, and count it as done."""
        before, after = self._cells[self.steps_done : self.steps_done + 2, self._boat]
        self.steps_done += 1
        offset = (int(after[0] - before[0]), int(after[1] - before[1]))
        return next(move for move in Move if move.offset == offset)
