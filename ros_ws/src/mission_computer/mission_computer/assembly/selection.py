"""Stage I, its end: which of the dispatches that the tabu search has found is taken.

The paper ranks candidates by the distance of boats to targets, then by the depth of the tree, then by docked contacts.
Boats do not drive straight to their targets, though: they drive to the guideposts of stage III, wait there for their
partners, and join level by level. So the distance is measured along the guideposts here. The longest of these ways
comes first, because no assembly along these guideposts takes fewer steps; eq. (25) asks for the arrival time.

Two candidates in which the same layouts stand on the same targets differ by exchanges of boats alone. Of all of them
the one of shortest ways is an assignment problem, so the search need not find it.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from mission_computer.assembly.constraint_model import turns_to
from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.extension import extend
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.travel import boats_by_class, exchanged_within_classes, travel_matrix
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Layout
from swarm_msgs_py.assembly.plan import AssemblyTree, Dispatch, Guideposts, ways_home
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem
from swarm_msgs_py.errors import AssemblyError, NoDispatchError

TREES_MAX = 24
"""Candidates that are worked out to guideposts, those of shortest straight travel first."""

Rank = tuple[int, int, int, int]
Pattern = tuple[tuple[Layout, ...], list[int]]
"""Layout of each target, and boats that can be turned so."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A dispatch, and how it is put together.

    Attributes
    ----------
    dispatch : Dispatch
    tree : AssemblyTree
    guideposts : Guideposts
    rank : tuple of int
        Longest way along the guideposts and their total [cells], depth of the tree, docked contacts (negative).
    """

    dispatch: Dispatch
    tree: AssemblyTree
    guideposts: Guideposts
    rank: Rank


def select(problem: AssemblyProblem, structure: Structure, found: Collection[Dispatch]) -> Candidate:
    """Return the best candidate.

    Raises
    ------
    NoDispatchError
        If no tree of straight cuts takes any of them apart.
    AssemblyError
        If no extension fits the grid.
    """
    best: Candidate | None = None
    no_room: AssemblyError | None = None
    trees = 0
    for pattern in _patterns(problem, found):
        docked = docked_contacts(problem.targets, pattern[0], problem.gender)
        tree = CutForest(structure, docked).tree()
        if tree is None:
            continue
        trees += 1
        try:
            posts = extend(problem, tree)
        except AssemblyError as error:
            no_room = error
        else:
            candidate = _worked_out(problem, pattern, tree, posts, len(docked))
            if candidate is not None and (best is None or candidate.rank < best.rank):
                best = candidate
        if trees >= TREES_MAX and best is not None:
            break
    if best is not None:
        return best
    if no_room is not None:
        raise no_room
    if trees:
        raise AssemblyError(f"{problem.name}: idle boats lie where the structure is put together; start them elsewhere")
    raise NoDispatchError(
        f"{problem.name}: none of {len(found)} dispatches that join the structure can be put together along"
        " straight lines"
    )


def _patterns(problem: AssemblyProblem, found: Collection[Dispatch]) -> list[Pattern]:
    """Return the different layouts on the targets, each with boats of short straight travel, shortest first."""
    distances = travel_matrix(problem)
    targets = np.arange(problem.target_count)
    classes = list(boats_by_class(problem).values())
    patterns = {dispatch.layouts(problem): dispatch.boats for dispatch in found}
    ranked = []
    for layouts, some in patterns.items():
        boats = exchanged_within_classes(distances, classes, some, is_strict=False)
        ways = distances[boats, targets]
        ranked.append((int(ways.max()), int(ways.sum()), layouts, boats))
    ranked.sort(key=lambda one: one[:2])
    return [(layouts, boats) for _, _, layouts, boats in ranked]


def _worked_out(
    problem: AssemblyProblem, pattern: Pattern, tree: AssemblyTree, posts: Guideposts, docked: int
) -> Candidate | None:
    """Return a candidate with boats of short ways along its guideposts, None if idle boats lie in these ways."""
    layouts, boats = pattern
    leaf_of = tree.leaf_of()
    leaves = [leaf_of[target] for target in range(problem.target_count)]
    shifts = np.array(posts.shifts, dtype=np.int64)
    places = np.array(problem.targets, dtype=np.int64) + shifts[leaves]
    starts = np.array(problem.starts, dtype=np.int64)
    ways = np.abs(starts[:, None] - places[None]).sum(axis=2) + np.array(ways_home(tree, posts))[leaves]
    chosen = exchanged_within_classes(ways, list(boats_by_class(problem).values()), boats, is_strict=True)
    turns = tuple(turns_to(problem.layouts[boat], layout) for boat, layout in zip(chosen, layouts, strict=True))
    dispatch = Dispatch(tuple(chosen), turns)
    for idle in dispatch.idle(problem):
        for node, shift in zip(tree.nodes, shifts, strict=True):
            cells = np.array(problem.targets)[list(node.targets)] + shift
            if (np.abs(cells - starts[idle]).max(axis=1) < CLEARANCE).any():
                return None
    taken = ways[chosen, np.arange(problem.target_count)]
    return Candidate(dispatch, tree, posts, (int(taken.max()), int(taken.sum()), tree.depth, -docked))
