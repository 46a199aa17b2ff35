"""Boats on a grid: one boat per cell, docked boats move together, frames may be lost. The fast world of assemblies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from swarm_msgs_py.assembly.boat_frames import BoatFrame, Move
from swarm_msgs_py.assembly.docking import docked_groups
from swarm_msgs_py.assembly.faces import Cell, turned
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem, chebyshev
from swarm_msgs_py.types import IntArray


class GridWorld:
    """True cells of all boats, what they see and hear, and what their moves do.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
        How boats are turned: they turn within the first step.
    perception_radius : int
        How far boats see [cells], Chebyshev.
    frame_loss : float
        Share of frames that a receiver does not get.
    rng : Generator
        Decides which.
    """

    def __init__(
        self,
        problem: AssemblyProblem,
        dispatch: Dispatch,
        perception_radius: int,
        frame_loss: float,
        rng: np.random.Generator,
    ) -> None:
        self._gender = problem.gender
        self._radius = perception_radius
        self._loss = frame_loss
        self._rng = rng
        turns = dict(zip(dispatch.boats, dispatch.turns, strict=True))
        self._layouts = [turned(layout, turns.get(boat, 0)) for boat, layout in enumerate(problem.layouts)]
        self.cells: list[Cell] = list(problem.starts)
        self.history: list[list[Cell]] = [list(self.cells)]

    def seen(self, boat: int) -> tuple[Cell, ...]:
        """Return the occupied cells around a boat, without its own, ascending."""
        here = self.cells[boat]
        return tuple(sorted(cell for cell in self.cells if 0 < chebyshev(cell, here) <= self._radius))

    def heard(self, boat: int, frames: Sequence[BoatFrame]) -> list[BoatFrame]:
        """Return the frames of others that a boat receives."""
        foreign = [frame for frame in frames if frame.boat != boat]
        if self._loss <= 0.0:
            return foreign
        lost = self._rng.random(len(foreign)) < self._loss
        return [frame for frame, is_lost in zip(foreign, lost.tolist(), strict=True) if not is_lost]

    def move(self, commands: Mapping[int, Move]) -> None:
        """Move every docked group as the boat of lowest number in it commands."""
        number = {cell: boat for boat, cell in enumerate(self.cells)}
        placed = {cell: self._layouts[boat] for cell, boat in number.items()}
        for group in docked_groups(placed, self._gender):
            boats = sorted(number[cell] for cell in group)
            dx, dy = commands.get(boats[0], Move.STAY).offset
            for boat in boats:
                x, y = self.cells[boat]
                self.cells[boat] = (x + dx, y + dy)
        self.history.append(list(self.cells))

    def track(self) -> IntArray:
        """Return the cells of all boats so far, (steps + 1, n, 2)."""
        return np.array(self.history, dtype=np.int64)
