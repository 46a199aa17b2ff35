"""Who must leave a place before whom: the order in timed paths that boats keep, whatever the clock says.

A group leaves for its next cells when everybody who was too near to them at this step or before has gone. A wait for a
step that lies behind is always over some day; groups that wait for each other's *same* step could wait in a ring, and
such paths are no plan.
"""

from __future__ import annotations

import graphlib

import numpy as np
from scipy.spatial import cKDTree

from swarm_msgs_py.assembly.plan import AssemblyTree, Dispatch, TimedPaths
from swarm_msgs_py.assembly.problem import CLEARANCE, AssemblyProblem
from swarm_msgs_py.types import IntArray

Crew = tuple[int, ...]


def crews_of(
    problem: AssemblyProblem, dispatch: Dispatch, tree: AssemblyTree, paths: TimedPaths, boat: int
) -> list[Crew]:
    """Return the docked group of a boat at each step, ascending.

    That is the largest node that stands as in the structure from that step on. Boats that were stopped may have stood
    so before without holding each other.
    """
    shifts = paths.cells[:, list(dispatch.boats)] - np.array(problem.targets)
    node = tree.leaf_of()[dispatch.boats.index(boat)]
    found: list[Crew] = []
    while True:
        joins = len(shifts)
        if node > 0:
            larger = shifts[:, list(tree.nodes[tree.nodes[node].parent].targets)]
            apart = np.flatnonzero((larger != larger[:, :1]).any(axis=(1, 2)))
            joins = int(apart[-1]) + 1 if len(apart) else 0
        crew = tuple(sorted(dispatch.boats[target] for target in tree.nodes[node].targets))
        found += [crew] * (joins - len(found))
        if len(found) == len(shifts):
            return found
        node = tree.nodes[node].parent


def nodes_at(problem: AssemblyProblem, dispatch: Dispatch, tree: AssemblyTree, cells: IntArray) -> list[int]:
    """Return the node of each docked group when boats stand at `cells` (n, 2), largest groups that stand whole."""
    shifts = cells[list(dispatch.boats)] - np.array(problem.targets)
    groups, border = [], [0]
    while border:
        number = border.pop()
        node = tree.nodes[number]
        rows = shifts[list(node.targets)]
        if (rows == rows[0]).all():
            groups.append(number)
        else:
            border.extend(node.children)
    return sorted(groups)


def needed_steps(crews: list[Crew], cells: IntArray, others: IntArray, boat: int, step: int) -> dict[int, int]:
    """Return the steps that other boats must have reached before the group of a boat leaves for ``step + 1``.

    A group that stays where it is waits for nobody but its own: others may have been stopped right beside it.

    Parameters
    ----------
    crews : list of Crew
        Group of the boat at each step.
    cells : (steps + 1, n, 2) int array
    others : (k,) int array
        All boats with a target.
    boat, step : int
    """
    crew = list(crews[step])
    others = others[~np.isin(others, crew)]
    needed = {member: step for member in crew if member != boat}
    partners = set(crews[step + 1]) - set(crew)
    places = cells[step + 1, crew]
    then = cells[: step + 1, others]
    near = (np.abs(then[:, :, None] - places[None, None]).max(axis=3) < CLEARANCE).any(axis=2)
    is_moving = bool((places != cells[step, crew]).any())
    for number, other in enumerate(others.tolist()):
        steps = np.flatnonzero(near[:, number])
        if other in partners:
            needed[other] = step  # the last step before docking is made together
        elif len(steps) and is_moving:
            needed[other] = int(steps[-1]) + 1
    return needed


def turning_step(problem: AssemblyProblem, crews: list[Crew], cells: IntArray, boat: int) -> int:
    """Return the first step at which a boat may be turned: nobody but its group is beside it.

    Boats start with room around them, and turn there. Boats that were stopped may stand beside each other without
    holding each other; then hulls would meet if one turned before they are apart.

    Parameters
    ----------
    problem : AssemblyProblem
    crews : list of Crew
        Group of the boat at each step.
    cells : (steps + 1, n, 2) int array
    boat : int
    """
    still = np.array(problem.obstacles, dtype=np.int64).reshape(-1, 2)
    for step, crew in enumerate(crews):
        others = np.concatenate([np.delete(cells[step], list(crew), axis=0), still])
        if not (np.abs(others - cells[step, boat]).max(axis=1) < CLEARANCE).any():
            return step
    return 0


def waits_in_ring(problem: AssemblyProblem, dispatch: Dispatch, tree: AssemblyTree, paths: TimedPaths) -> bool:
    """Return whether boats that keep the order of the paths could come to wait for each other forever."""
    movers = np.array(sorted(dispatch.boats))
    groups = _groups_by_step(problem, dispatch, tree, paths)
    for step in range(paths.steps):
        before, after = paths.cells[step], paths.cells[step + 1]
        group_of, joined = groups[step], groups[step + 1]
        graph: dict[int, set[int]] = {}
        near = cKDTree(after[movers]).query_ball_tree(cKDTree(before[movers]), CLEARANCE - 0.5, p=np.inf)
        moves = (before != after).any(axis=1)
        for row, hits in enumerate(near):
            mine = movers[row]
            for other in movers[hits] if moves[mine] else ():
                if group_of[mine] != group_of[other] and joined[mine] != joined[other]:
                    graph.setdefault(int(group_of[mine]), set()).add(int(group_of[other]))
        try:
            graphlib.TopologicalSorter(graph).prepare()
        except graphlib.CycleError:
            return True
    return False


def _groups_by_step(
    problem: AssemblyProblem, dispatch: Dispatch, tree: AssemblyTree, paths: TimedPaths
) -> list[IntArray]:
    """Return the number of the docked group of each boat at each step, -1 for boats without a target."""
    found = [np.full(problem.boat_count, -1) for _ in range(paths.steps + 1)]
    if problem.is_midway:  # boats that were stopped may stand as in the structure without holding each other
        for boat in dispatch.boats:
            for groups, crew in zip(found, crews_of(problem, dispatch, tree, paths, boat), strict=True):
                groups[boat] = crew[0]
        return found
    for groups, cells in zip(found, paths.cells, strict=True):
        for number in nodes_at(problem, dispatch, tree, cells):
            groups[[dispatch.boats[target] for target in tree.nodes[number].targets]] = number
    return found
