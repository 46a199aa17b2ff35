"""The assembly run backward: the finished structure comes apart, and every boat drives to its start.

Forward, groups must find each other; backward, a group has nobody to wait for. All clearance rules read the same in
both directions, so a disassembly without violations is, in reverse, an assembly without violations.

Each step, groups choose in the order of their urgency: stay, move by a cell, or split along a straight line so that its
two parts leave each other along the normal. A group that needs room makes the groups in its way choose first, with its
own move taken for granted (priority inheritance with backtracking, as in PIBT: Okumura et al., Artificial Intelligence
310, 2022). Nobody ever chooses to be within a clearance of a group that has not agreed to leave, so staying is always
possible.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.lattice import Lattice
from mission_computer.assembly.structure import Cut, Part, members
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.assembly.plan import Axis, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem

REQUESTS_MAX = 400
"""Groups that may be asked to choose within one step, per group; then nobody asks any more and the rest stays."""

_TOWARD = {Axis.X: (Face.LEFT, Face.RIGHT), Axis.Y: (Face.DOWN, Face.UP)}  # where the low and high part of a cut go


@dataclass(frozen=True, slots=True, kw_only=True)
class Manner:
    """How a disassembly weighs its choices; different manners lead to different plans.

    Attributes
    ----------
    cut_weight : float
        Steps that a part is thought to lose for each cut that is still before it.
    steepness : float
        Base of the exponential in which a boat's expected arrival counts: the larger, the more the last boat matters.
    noise : float
        Weight of chance among choices, relative to the score of one step of the last boat.
    keeps_order : bool
        Whether groups never move up all around a ring within one step. Boats that are late by any time must be able to
        wait for each other (`waits_in_ring`), and in a ring nobody could be the first.
    """

    cut_weight: float = 0.5
    steepness: float = 2.0
    noise: float = 0.1
    keeps_order: bool = False


@dataclass(slots=True, eq=False)
class _Group:
    """A rigid group: its part of the structure, and the numbers of its boats' cells, targets ascending."""

    part: Part
    targets: tuple[int, ...]
    cells: list[int]


@dataclass(slots=True, eq=False)
class _Choice:
    """What a group does in a step: one group or two, each with its new cells."""

    score: float
    results: list[_Group]
    cut: Cut | None = None


@dataclass(slots=True)
class _Round:
    """What groups have chosen in this step so far."""

    chosen: dict[int, _Choice] = field(default_factory=dict)
    after: dict[int, set[int]] = field(default_factory=dict)  # groups that must have left before each one comes
    log: list[int] = field(default_factory=list)
    requests: int = 0

    def closes_ring(self, number: int) -> bool:
        """Return whether a group that has chosen waits for itself, over others that have."""
        seen: set[int] = set()
        border = list(self.after[number])
        while border:
            other = border.pop()
            if other == number:
                return True
            if other not in seen:
                seen.add(other)
                border.extend(self.after.get(other, ()))
        return False


class Disassembly:
    """One run of the structure coming apart.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    forest : CutForest
        Trees of the dispatched structure, which must be separable.
    manner : Manner
    rng : Generator
        Breaks ties.

    Attributes
    ----------
    history : list of list of int
        Cell number of the boat of each target, per backward step.
    cuts : dict
        Cut of each part that came apart.
    """

    def __init__(
        self, problem: AssemblyProblem, dispatch: Dispatch, forest: CutForest, manner: Manner, rng: np.random.Generator
    ) -> None:
        idle = [problem.starts[boat] for boat in dispatch.idle(problem)]
        self.lattice = Lattice(problem, [*idle, *problem.obstacles])
        self._forest = forest
        self._manner = manner
        self._rng = rng
        self._goals = [self.lattice.number(problem.starts[boat]) for boat in dispatch.boats]
        self._goal_cells = [problem.starts[boat] for boat in dispatch.boats]
        whole = (1 << problem.target_count) - 1
        self._groups = [_Group(whole, members(whole), [self.lattice.number(cell) for cell in problem.targets])]
        self._now = [-1] * self.lattice.count  # group at each cell
        self._next = [-1] * self.lattice.count  # group that will be there
        self.history = [list(self._groups[0].cells)]
        self.cuts: dict[Part, Cut] = {}

    @property
    def keeps_order(self) -> bool:
        """See `Manner.keeps_order`."""
        return self._manner.keeps_order

    @property
    def is_clear(self) -> bool:
        """Whether the finished structure keeps clear of everything that never moves."""
        whole = self._groups[0]
        return len(self.history) > 1 or self._may_be_at(whole.targets, whole.cells)

    @property
    def is_apart(self) -> bool:
        """Whether every group is one that cannot come apart: a single boat, as a rule."""
        return len(self._groups) == self._forest.atom_count

    @property
    def groups(self) -> list[tuple[int, ...]]:
        """Targets of the boats in each group that is larger than one."""
        return [group.targets for group in self._groups if len(group.targets) > 1]

    @property
    def expected_end(self) -> int:
        """Step at which the last boat would arrive if nothing held it up."""
        remaining = (self.lattice.distance(*pair) for pair in zip(self.history[-1], self._goals, strict=True))
        return len(self.history) - 1 + max(remaining)

    def step(self) -> None:
        """Let every group choose, and move them all."""
        for number, group in enumerate(self._groups):
            for cell in group.cells:
                self._now[cell] = number
        state = _Round()
        for number in self._by_urgency():
            if number not in state.chosen:
                self._choose(number, state)
        for group in self._groups:
            for cell in group.cells:
                self._now[cell] = -1
        after: list[_Group] = []
        for number, group in enumerate(self._groups):
            choice = state.chosen[number]
            if choice.cut is not None:
                self.cuts[group.part] = choice.cut
            after += choice.results
        places = [0] * len(self._goals)
        for group in after:
            for target, cell in zip(group.targets, group.cells, strict=True):
                places[target] = cell
                self._next[cell] = -1
        self._groups = after
        self.history.append(places)

    def _by_urgency(self) -> list[int]:
        noise = self._rng.random(len(self._groups)).tolist()
        lateness = [max(self._expected(group)) for group in self._groups]
        return sorted(range(len(self._groups)), key=lambda number: (-lateness[number], noise[number]))

    def _expected(self, group: _Group) -> list[float]:
        """Return the steps that each boat of a group is thought to need yet."""
        cuts = self._manner.cut_weight * self._forest.least_depth(group.part)
        lattice, goals = self.lattice, self._goal_cells
        ways = []
        for target, number in zip(group.targets, group.cells, strict=True):
            x, y = lattice.cell(number)
            u, v = goals[target]
            ways.append(abs(x - u) + abs(y - v) + cuts)
        return ways

    def _score(self, results: list[_Group], latest: float) -> float:
        base = self._manner.steepness
        return math.fsum(math.pow(base, way - latest) for group in results for way in self._expected(group))

    def _choices(self, group: _Group) -> list[_Choice]:
        latest = max(self._expected(group))
        choices = [_Choice(0.0, [_Group(group.part, group.targets, cells)]) for cells in self._moves(group)]
        choices += self._splits(group)
        noise = self._rng.random(len(choices)) * self._manner.noise
        for choice, chance in zip(choices, noise.tolist(), strict=True):
            choice.score = self._score(choice.results, latest) * (1.0 + chance)
        return sorted(choices, key=lambda choice: choice.score)

    def _may_be_at(self, targets: tuple[int, ...], cells: list[int]) -> bool:
        """Return whether cells are open; a boat may be where it starts, however near to what."""
        closed, goals = self.lattice.is_closed, self._goals
        return not any(closed[cell] and goals[target] != cell for target, cell in zip(targets, cells, strict=True))

    def _moves(self, group: _Group) -> Iterator[list[int]]:
        """Yield the cells of a rigid group that stays, and that makes a step in each direction."""
        yield group.cells
        for move in self.lattice.moves:
            moved = [cell + move for cell in group.cells]
            if self._may_be_at(group.targets, moved):
                yield moved

    def _splits(self, group: _Group) -> Iterator[_Choice]:
        if self._forest.is_atom(group.part):
            return
        place = dict(zip(group.targets, group.cells, strict=True))
        for cut in self._forest.valid_cuts(group.part):
            low, high = members(cut.low), members(cut.high)
            down, up = (self.lattice.moves[face] for face in _TOWARD[cut.axis])
            for low_move, high_move in ((down, up), (down, 0), (0, up)):
                results = [
                    _Group(part, targets, [place[target] + move for target in targets])
                    for part, targets, move in ((cut.low, low, low_move), (cut.high, high, high_move))
                ]
                if all(self._may_be_at(part.targets, part.cells) for part in results):
                    yield _Choice(0.0, results, cut)

    def _choose(self, number: int, state: _Round) -> bool:
        """Let a group choose, and the groups in its way before it is final; return whether it could."""
        for choice in self._choices(self._groups[number]):
            in_way = self._in_way(number, choice, state)
            if in_way is None or (in_way and state.requests > REQUESTS_MAX * len(self._groups)):
                continue
            mark = len(state.log)
            self._commit(number, choice, state)
            if self._manner.keeps_order and state.closes_ring(number):
                self._undo(mark, state)
                continue
            state.requests += len(in_way)
            if all(other in state.chosen or self._choose(other, state) for other in in_way):
                return True
            self._undo(mark, state)
        return False

    def _in_way(self, number: int, choice: _Choice, state: _Round) -> list[int] | None:
        """Return the groups that would have to leave; None if one that has chosen would be too near."""
        now, after, near = self._now, self._next, self.lattice.near
        others: dict[int, None] = {}
        for group in choice.results:
            for cell in group.cells:
                for step in near:
                    at = cell + step
                    if after[at] >= 0:
                        return None
                    if now[at] >= 0 and now[at] != number and now[at] not in state.chosen:
                        others[now[at]] = None
        return list(others)

    def _commit(self, number: int, choice: _Choice, state: _Round) -> None:
        state.chosen[number] = choice
        state.log.append(number)
        for group in choice.results:
            for cell in group.cells:
                self._next[cell] = number
        if self._manner.keeps_order:
            near = (
                self._now[cell + step] for group in choice.results for cell in group.cells for step in self.lattice.near
            )
            state.after[number] = {other for other in near if other not in {-1, number}}

    def _undo(self, mark: int, state: _Round) -> None:
        for number in state.log[mark:]:
            state.after.pop(number, None)
            for group in state.chosen.pop(number).results:
                for cell in group.cells:
                    self._next[cell] = -1
        del state.log[mark:]
