"""Did boats dock as the structure asks, and with nobody else? Judged from what latched, not from what was planned."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Cell, Face, turned_face
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.bodies import Latch
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.pool import LatchEvent

Side = tuple[int, Face]

AT_CELL_M = 0.06
"""A boat whose center is nearer to that of a cell fills it [m]."""


@dataclass(frozen=True, slots=True)
class DockingAudit:
    """What came out.

    Attributes
    ----------
    docked_contacts, wanted_contacts : int
        Pairs of sides that hold in the end, and that the structure has.
    components : int
        Docked groups among the dispatched boats in the end; 1 if the structure holds together.
    violations : tuple of str
        Undesired docks, docks that came apart, hulls that ran into each other; one line each.
    """

    docked_contacts: int
    wanted_contacts: int
    components: int
    violations: tuple[str, ...]

    @property
    def is_complete_and_clean(self) -> bool:
        """Whether the structure holds together and nothing went wrong on the way."""
        return self.components == 1 and not self.violations


def audit_docking(
    plans: Sequence[tuple[AssemblyProblem, Dispatch]],
    events: Sequence[LatchEvent],
    overlaps: Iterable[tuple[int, int]],
) -> DockingAudit:
    """Return what came of an assembly in continuous space.

    Parameters
    ----------
    plans : sequence of (AssemblyProblem, Dispatch)
        What was to be built, and who was to go where, one after the other; turns are from the orientation at the start.
    events : sequence of LatchEvent
        All that latched and came apart, in order of time.
    overlaps : iterable of (int, int)
        Boats whose hulls overlapped.
    """
    wanted = [_wanted(problem, dispatch) for problem, dispatch in plans]
    anywhere = set().union(*wanted)
    held: set[Latch] = set()
    violations = []
    for event in events:
        latch = event.latch
        where = f"{event.time_s:.2f} s: boats {latch.boat} and {latch.other}"
        if event.holds:
            held.add(latch)
            if frozenset(((latch.boat, latch.face), (latch.other, latch.other_face))) not in anywhere:
                violations.append(f"{where} dock where the structure has no such neighbors")
        else:
            held.discard(latch)
            violations.append(f"{where} came apart")
    violations += [f"hulls of boats {one} and {other} ran into each other" for one, other in sorted(overlaps)]
    boats = set(plans[-1][1].boats)
    final = [latch for latch in held if latch.boat in boats and latch.other in boats]
    return DockingAudit(len(final), len(wanted[-1]), len(_groups(sorted(boats), final)), tuple(violations))


def _wanted(problem: AssemblyProblem, dispatch: Dispatch) -> set[frozenset[Side]]:
    boats, turns = dispatch.boats, dispatch.turns
    return {
        frozenset(
            (
                (boats[one.one], turned_face(one.face, -turns[one.one])),
                (boats[one.other], turned_face(one.face.opposite, -turns[one.other])),
            )
        )
        for one in docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender)
    }


def _groups(boats: Iterable[int], latches: Iterable[Latch]) -> list[list[int]]:
    """Return the docked groups among boats, in the order of their first."""
    group = {boat: boat for boat in boats}

    def root(boat: int) -> int:
        while group.setdefault(boat, boat) != boat:
            boat = group[boat]
        return boat

    for latch in latches:
        group[root(latch.boat)] = root(latch.other)
    found: dict[int, list[int]] = {}
    for boat in sorted(group):
        found.setdefault(root(boat), []).append(boat)
    return sorted(found.values())


@dataclass(frozen=True, slots=True)
class Standing:
    """What holds together at an instant.

    Attributes
    ----------
    filled : int
        Most targets that a docked group fills, all of them shifted alike by whole cells.
    shift : (int, int)
        That shift [cells]; (0, 0) if there is no better one.
    docks : int
        Pairs of sides that hold.
    components : int
        Docked groups, boats on their own included.
    """

    filled: int
    shift: Cell
    docks: int
    components: int


def standing_of(problem: AssemblyProblem, positions: FloatArray, latches: Iterable[Latch]) -> Standing:
    """Return what holds together, from where boats truly are.

    Parameters
    ----------
    problem : AssemblyProblem
    positions : (n, 2) array
        Centers [m].
    latches : iterable of Latch
    """
    held = list(latches)
    groups = _groups(range(len(positions)), held)
    nearest = np.rint(positions / CELL_M).astype(np.int64)
    at_cell = np.abs(positions - CELL_M * nearest).max(axis=1) < AT_CELL_M
    cells = [(int(x), int(y)) if near else None for (x, y), near in zip(nearest, at_cell, strict=True)]
    filled, shift = 0, (0, 0)
    for group in groups:
        stands = [cell for boat in group if (cell := cells[boat]) is not None]
        shifts = Counter((x - u, y - v) for x, y in stands for u, v in problem.targets)
        for place, count in sorted(shifts.items(), key=lambda item: (item[0] != (0, 0), item[0])):
            if count > filled:
                filled, shift = count, place
    return Standing(filled, shift, len(held), len(groups))
