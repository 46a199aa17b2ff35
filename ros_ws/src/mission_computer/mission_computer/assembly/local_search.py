"""Dispatch of large structures by guided local search.

The tree of cuts is fixed first, from the geometry alone: the most even one. What remains is to have one docked contact
across each of its cuts. Every contact crosses exactly one cut, so the cost of a state, the weighted number of cuts
without a docked contact, changes only around the targets that a move touches. In a local minimum the weights of the
cuts that are still open grow (breakout: Morris, AAAI 1993), which changes the landscape until the search gets out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from mission_computer.assembly.constraint_model import turns_to
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.structure import Part, Structure, part_of
from mission_computer.assembly.travel import boats_by_class, shortest_assignment, travel_matrix, usable_boats
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.faces import Layout, distinct_turns, turned
from swarm_msgs_py.assembly.plan import AssemblyTree, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalSearchLimits:
    """Bounds of the search.

    Attributes
    ----------
    moves_per_target : int
        Moves per target of the structure before the search gives up, and a longer travel is allowed. Searches that
        succeed need a few; one that fails should cost no more than some of those.
    partners : int
        Boats that are considered for an exchange at each end of a contact.
    """

    moves_per_target: int = 10
    partners: int = 24


def even_tree(structure: Structure) -> AssemblyTree | None:
    """Return the most even tree that the geometry allows, None if no tree of straight cuts exists at all."""
    return CutForest(structure, structure.contacts).tree()


class LocalSearch:
    """Search for a dispatch that docks across every cut of a given tree.

    Parameters
    ----------
    problem : AssemblyProblem
    structure : Structure
    tree : AssemblyTree
    travel_max : int
        No boat may travel farther [cells], except where the assignment that the search begins from does.
    rng : Generator
    """

    def __init__(
        self,
        problem: AssemblyProblem,
        structure: Structure,
        tree: AssemblyTree,
        travel_max: int,
        rng: np.random.Generator,
    ) -> None:
        self._problem = problem
        self._rng = rng
        distances = travel_matrix(problem)
        self._may_take = (distances <= travel_max).tolist()
        usable = usable_boats(problem)
        rows = shortest_assignment(distances[list(usable)])
        used = {usable[row] for row in rows}
        # Behind the targets come berths of idle boats, so that replacing a boat is an exchange like any other.
        self._boats = [usable[row] for row in rows] + [boat for boat in usable if boat not in used]
        self._around: list[list[Contact]] = [[] for _ in self._boats]
        for contact in structure.contacts:
            self._around[contact.one].append(contact)
            self._around[contact.other].append(contact)
        self._options = [tuple(turned(layout, turns) for turns in distinct_turns(layout)) for layout in problem.layouts]
        self._stands: list[Layout] = [
            self._options[boat][int(rng.integers(len(self._options[boat])))] for boat in self._boats
        ]
        self._cut_of = _cut_of_contacts(structure, tree)
        self._weights = [1] * len(tree.nodes)
        self._docked = [0] * len(tree.nodes)  # docked contacts across the cut of each node
        for contact in structure.contacts:
            self._docked[self._cut_of[contact]] += self._is_docked(contact)
        self._crossing: dict[int, list[Contact]] = {}
        for contact in structure.contacts:
            self._crossing.setdefault(self._cut_of[contact], []).append(contact)

    @property
    def open_cuts(self) -> list[int]:
        """Nodes of the tree whose cut no docked contact crosses."""
        return [node for node in self._crossing if not self._docked[node]]

    def run(self, limits: LocalSearchLimits) -> Dispatch | None:
        """Return a dispatch that docks across every cut, None if none was found within the limits."""
        for _ in range(limits.moves_per_target * self._problem.target_count):
            unmet = self.open_cuts
            if not unmet:
                return self._dispatch()
            crossing = self._crossing[unmet[int(self._rng.integers(len(unmet)))]]
            contact = crossing[int(self._rng.integers(len(crossing)))]
            if not self._mend(contact, limits.partners):
                for node in unmet:
                    self._weights[node] += 1
        return None

    def _mend(self, contact: Contact, partners: int) -> bool:
        """Make the best change that docks a contact; return whether it lowered the weighted cost."""
        best_change, best_cost = None, 0.0
        for change in self._changes(contact, partners):
            cost = self._cost_of(change)
            if cost is not None and (best_change is None or cost < best_cost):
                best_change, best_cost = change, cost
        if best_change is None:
            return False
        if best_cost <= 0:
            self._apply(best_change)
        return best_cost < 0

    def _changes(self, contact: Contact, partners: int) -> Iterator[dict[int, tuple[int, Layout]]]:
        """Yield changes that dock a contact: berth -> boat and its turned layout."""
        one, other = contact.one, contact.other
        yield from self._turnings(contact, {})
        for end in (one, other):
            candidates = self._rng.permutation(len(self._boats))[:partners].tolist()
            for berth in candidates:
                if berth in (one, other) or not self._may_swap(end, berth):
                    continue
                yield from self._turnings(contact, {end: self._boats[berth], berth: self._boats[end]})

    def _turnings(self, contact: Contact, boats: dict[int, int]) -> Iterator[dict[int, tuple[int, Layout]]]:
        ends = (contact.one, contact.other)
        boat_at = [boats.get(end, self._boats[end]) for end in ends]
        joined = [
            (one, other)
            for one, other in product(*(self._options[boat] for boat in boat_at))
            if self._problem.gender.joins(one[contact.face], other[contact.face.opposite])
        ]
        for layouts in joined:
            change = {end: (boat, layout) for end, boat, layout in zip(ends, boat_at, layouts, strict=True)}
            for berth, boat in boats.items():
                if berth not in change:  # the partner of an exchange: turned as fits its new place best
                    change[berth] = (boat, self._best_turn(berth, boat))
            yield change

    def _best_turn(self, berth: int, boat: int) -> Layout:
        options = self._options[boat]
        if berth >= self._problem.target_count or len(options) == 1:
            return options[0]
        return max(options, key=lambda layout: self._worth(berth, layout))

    def _worth(self, berth: int, layout: Layout) -> int:
        """Return the weight of the cuts that a layout docks across and that no other contact serves."""
        joins = self._problem.gender.joins
        worth = 0
        for contact in self._around[berth]:
            cut = self._cut_of[contact]
            is_first = contact.one == berth
            face = contact.face if is_first else contact.face.opposite
            beyond = self._stands[contact.other if is_first else contact.one]
            if joins(layout[face], beyond[face.opposite]):
                alone = self._docked[cut] - self._is_docked(contact) == 0
                worth += self._weights[cut] * 4 if alone else 1
        return worth

    def _may_swap(self, one: int, other: int) -> bool:
        count = self._problem.target_count
        return all(
            berth >= count or self._may_take[boat][berth]
            for berth, boat in ((one, self._boats[other]), (other, self._boats[one]))
        )

    def _cost_of(self, change: dict[int, tuple[int, Layout]]) -> float | None:
        """Return by how much a change would raise the weighted number of open cuts."""
        old = {berth: self._stands[berth] for berth in change}
        touched = {contact for berth in change for contact in self._around[berth]}
        delta: dict[int, int] = {}
        for contact in touched:
            cut = self._cut_of[contact]
            delta[cut] = delta.get(cut, 0) - self._is_docked(contact)
        for berth, (_, layout) in change.items():
            self._stands[berth] = layout
        for contact in touched:
            delta[self._cut_of[contact]] += self._is_docked(contact)
        for berth, layout in old.items():
            self._stands[berth] = layout
        cost = 0.0
        for cut, change_of in delta.items():
            before = self._docked[cut]
            cost += self._weights[cut] * ((before + change_of == 0) - (before == 0))
        return cost

    def _apply(self, change: dict[int, tuple[int, Layout]]) -> None:
        touched = sorted(
            {contact for berth in change for contact in self._around[berth]}, key=lambda c: (c.one, c.face)
        )
        for contact in touched:
            self._docked[self._cut_of[contact]] -= self._is_docked(contact)
        for berth, (boat, layout) in change.items():
            self._boats[berth], self._stands[berth] = boat, layout
        for contact in touched:
            self._docked[self._cut_of[contact]] += self._is_docked(contact)

    def _is_docked(self, contact: Contact) -> bool:
        one, other = self._stands[contact.one], self._stands[contact.other]
        return self._problem.gender.joins(one[contact.face], other[contact.face.opposite])

    def _dispatch(self) -> Dispatch:
        return shorten_within_classes(self._problem, self._stands[: self._problem.target_count], self._boats)


def shorten_within_classes(problem: AssemblyProblem, wanted: list[Layout], boats: list[int]) -> Dispatch:
    """Return the dispatch of short travel that puts these layouts on the targets.

    Parameters
    ----------
    problem : AssemblyProblem
    wanted : list of Layout
        Turned layout of each target.
    boats : list of int
        Boat of each target, some assignment of the right classes; idle boats may follow.
    """
    chosen = list(boats[: problem.target_count])
    distances = travel_matrix(problem)
    for members in boats_by_class(problem).values():
        targets = [target for target, boat in enumerate(chosen) if boat in set(members)]
        if targets:
            rows = shortest_assignment(distances[np.ix_(members, targets)])
            for target, row in zip(targets, rows, strict=True):
                chosen[target] = members[row]
    turns = tuple(turns_to(problem.layouts[boat], layout) for boat, layout in zip(chosen, wanted, strict=True))
    return Dispatch(tuple(chosen), turns)


def _cut_of_contacts(structure: Structure, tree: AssemblyTree) -> dict[Contact, int]:
    """Return the node of the tree at which each contact's ends part."""
    parts: list[Part] = [part_of(node.targets) for node in tree.nodes]
    found: dict[Contact, int] = {}
    for contact in structure.contacts:
        number = 0
        while True:
            low, high = tree.nodes[number].children
            inside = [child for child in (low, high) if parts[child] >> contact.one & parts[child] >> contact.other & 1]
            if not inside:
                break
            number = inside[0]
        found[contact] = number
    return found
