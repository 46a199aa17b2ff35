"""Stage I as published: tabu search over dispatches for the least number of docked pieces (algorithm 1 of the paper).

The cost of a dispatch, eq. (26), is the number of connected components of the docking graph, idle boats counted as
single ones; it cannot be less than ``N - M + 1``, eq. (27). Idle boats add a constant, so the search counts the pieces
of the structure, whose least is 1. Three moves: two boats exchange their targets, a boat turns, an idle boat takes the
place of another; the last is an exchange with a berth beyond the targets.

The end rule (28) adapts to how hard the instance proved to be. It counts iterations instead of seconds, so that equal
seeds give equal dispatches. It holds from the first find on: a search that has found nothing goes on to its cap.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from mission_computer.assembly.constraint_model import turns_to
from mission_computer.assembly.selection import Candidate, select
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.travel import travel_matrix, usable_boats
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.faces import Layout, distinct_turns, turned
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import NoDispatchError


@dataclass(frozen=True, slots=True, kw_only=True)
class TabuLimits:
    """Constants of the search; defaults are those of the authors' simulator.

    Attributes
    ----------
    patience : float
        K of eq. (28).
    first_iterations : int
        T0 of eq. (28): iterations thought to be needed for the first find.
    iterations_max : int
        The search ends here in any case.
    tenure_share : float
        For how many iterations a move is tabu, as a share of the number of moves.
    moves_max : int
        Moves that are looked at per iteration, drawn anew each time; more moves than that are not worth their time.
    candidates_max : int
        The search ends with so many candidates: on large maps with many mechanisms nearly every iteration finds one.
    """

    patience: float = 3.0
    first_iterations: int = 1000
    iterations_max: int = 10_000
    tenure_share: float = 0.5
    moves_max: int = 64
    candidates_max: int = 1000


@dataclass(frozen=True, slots=True)
class TabuResult:
    """What the search found.

    Attributes
    ----------
    best : Candidate
        The dispatch that was selected.
    feasible : int
        Different dispatches found that join the structure.
    iterations : int
    """

    best: Candidate
    feasible: int
    iterations: int


Move = tuple[int, int, int]
"""Berth, other berth and 0 for an exchange; berth, -1 and quarter turns for a turn."""


class TabuSearch:
    """State of the search: which boat lies at which berth, and how it is turned.

    Parameters
    ----------
    problem : AssemblyProblem
    structure : Structure
    rng : Generator
    limits : TabuLimits
    """

    def __init__(
        self, problem: AssemblyProblem, structure: Structure, rng: np.random.Generator, limits: TabuLimits
    ) -> None:
        self._problem = problem
        self._rng = rng
        self._limits = limits
        usable = np.array(usable_boats(problem))
        self._boats: list[int] = rng.permutation(usable).tolist()
        options = [distinct_turns(layout) for layout in problem.layouts]
        self._turns = [0] * problem.boat_count
        for boat in self._boats:
            self._turns[boat] = options[boat][int(rng.integers(len(options[boat])))]
        count = problem.target_count
        idle = len(self._boats) - count
        self._travels: list[list[int]] = [[*row, *[0] * idle] for row in travel_matrix(problem).tolist()]
        self._moves: list[Move] = [(a, b, 0) for a in range(count) for b in range(a + 1, len(self._boats))]
        self._moves += [(a, -1, turns) for a in range(count) for turns in (1, 2, 3)]
        self._turned: list[list[Layout]] = [[turned(layout, t) for t in range(4)] for layout in problem.layouts]
        self._around: list[list[Contact]] = [[] for _ in range(count)]
        for contact in structure.contacts:
            self._around[contact.one].append(contact)
            self._around[contact.other].append(contact)
        self._links = [0] * count  # docked neighbors of each target, as bits
        for target in range(count):
            self._relink(target)
        self._pieces = self._count(self._links)
        self.least_pieces = self._pieces

    def run(self) -> tuple[dict[Dispatch, None], int]:
        """Return all dispatches found that join the structure, in order, and the iterations that it took."""
        limits = self._limits
        tabu: deque[Move] = deque(maxlen=max(1, int(limits.tenure_share * min(len(self._moves), limits.moves_max))))
        found: dict[Dispatch, None] = {}
        last_find = 0
        for iteration in range(limits.iterations_max):
            if self._pieces == 1:
                dispatch = self._dispatch()
                if dispatch not in found:
                    found[dispatch] = None
                    last_find = iteration
            # eq. (28): the efforts of all finds so far add up to the iteration of the last one
            budget = limits.patience * (last_find + limits.first_iterations) / (len(found) + 1)
            if found and (iteration - last_find > budget or len(found) >= limits.candidates_max):
                return found, iteration
            move = self._best_move(tabu)
            self._make(move)
            self._pieces = self._count(self._links)
            self.least_pieces = min(self.least_pieces, self._pieces)
            tabu.append(move if move[1] >= 0 else (move[0], -1, -move[2] % 4))
        return found, limits.iterations_max

    def _best_move(self, tabu: deque[Move]) -> Move:
        """Return the move of least cost among those drawn; of several the one of shortest travel, then at random."""
        order: list[int] = self._rng.permutation(len(self._moves))[: self._limits.moves_max].tolist()
        best, least = None, (0, 0)
        forbidden = set(tabu)
        for number in order:
            move = self._moves[number]
            if move in forbidden or self._is_idle_move(move):
                continue
            links = self._links_after(move)
            cost = self._pieces if links is None else self._count(links), self._detour(move)
            if best is None or cost < least:
                best, least = move, cost
        fallback: Move = self._moves[order[0]]
        return best if best is not None else fallback

    def _detour(self, move: Move) -> int:
        """Return by how much a move lengthens the total travel [cells]."""
        berth, other, _ = move
        if other < 0:
            return 0
        one, two = self._travels[self._boats[berth]], self._travels[self._boats[other]]
        return one[other] + two[berth] - one[berth] - two[other]

    def _is_idle_move(self, move: Move) -> bool:
        """Return whether a turn leaves its boat's layout as it is."""
        berth, other, turns = move
        if other >= 0:
            return False
        boat = self._boats[berth]
        return self._turned[boat][self._turns[boat]] == self._turned[boat][(self._turns[boat] + turns) % 4]

    def _links_after(self, move: Move) -> list[int] | None:
        """Return the docked neighbors of all targets after a move, None if no layout would change."""
        berth, other, _ = move
        before = self._layout(berth), self._layout(other) if other >= 0 else None
        self._swap(move)
        after = self._layout(berth), self._layout(other) if other >= 0 else None
        links = None
        if before != after:
            kept, self._links = self._links, self._links.copy()
            self._relink(berth)
            if 0 <= other < len(self._links):
                self._relink(other)
            links, self._links = self._links, kept
        self._swap((berth, other, -move[2]))
        return links

    def _make(self, move: Move) -> None:
        self._swap(move)
        self._relink(move[0])
        if 0 <= move[1] < len(self._links):
            self._relink(move[1])

    def _swap(self, move: Move) -> None:
        berth, other, turns = move
        if other >= 0:
            self._boats[berth], self._boats[other] = self._boats[other], self._boats[berth]
        else:
            boat = self._boats[berth]
            self._turns[boat] = (self._turns[boat] + turns) % 4

    def _layout(self, berth: int) -> Layout:
        boat = self._boats[berth]
        return self._turned[boat][self._turns[boat]]

    def _relink(self, target: int) -> None:
        """Find out anew which neighbors of a target are docked to it."""
        joins = self._problem.gender.joins
        for contact in self._around[target]:
            one, other = contact.one, contact.other
            if joins(self._layout(one)[contact.face], self._layout(other)[contact.face.opposite]):
                self._links[one] |= 1 << other
                self._links[other] |= 1 << one
            else:
                self._links[one] &= ~(1 << other)
                self._links[other] &= ~(1 << one)

    def _count(self, links: list[int]) -> int:
        """Return the number of docked pieces."""
        left = (1 << len(links)) - 1
        pieces = 0
        while left:
            border = left & -left
            left ^= border
            pieces += 1
            while border:
                bit = border & -border
                border ^= bit
                fresh = links[bit.bit_length() - 1] & left
                left ^= fresh
                border |= fresh
        return pieces

    def _dispatch(self) -> Dispatch:
        boats = tuple(self._boats[: self._problem.target_count])
        layouts = self._problem.layouts
        turns = tuple(turns_to(layouts[boat], self._turned[boat][self._turns[boat]]) for boat in boats)
        return Dispatch(boats, turns)


def tabu_dispatch(
    problem: AssemblyProblem, structure: Structure, rng: np.random.Generator, limits: TabuLimits
) -> TabuResult:
    """Return the dispatch that the published method selects, with its tree and guideposts.

    Raises
    ------
    NoDispatchError
        If no candidate was found, with the least number of pieces; or none of them can be taken apart.
    AssemblyError
        If no extension fits the grid.
    """
    search = TabuSearch(problem, structure, rng, limits)
    found, iterations = search.run()
    if not found:
        raise NoDispatchError(
            f"{problem.name}: found no dispatch that joins all {problem.target_count} targets in {iterations}"
            f" iterations; the best leaves {search.least_pieces} pieces"
        )
    return TabuResult(select(problem, structure, found), len(found), iterations)
