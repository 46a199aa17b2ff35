"""Timed guideposts: a cell for every boat and step, found backward from the finished structure."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from mission_computer.assembly.cut_tree import CutForest, tree_of
from mission_computer.assembly.disassembly import Disassembly, Manner
from mission_computer.assembly.homing import HomingLimits, plan_homing
from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.plan import AssemblyTree, Dispatch, TimedPaths
from swarm_msgs_py.assembly.precedence import waits_in_ring
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import IntArray

CUT_WEIGHTS = (1.0, 0.5, 1.5, 2.0)
"""Manners of coming apart, tried in turn: no single one is best for all structures."""
POOR = 2.0
"""Plans of more steps than so many times those of the longest straight way are poor."""


@dataclass(frozen=True, slots=True)
class TimedPlan:
    """Paths of all boats, and the order in which their groups join."""

    paths: TimedPaths
    tree: AssemblyTree


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedLimits:
    """Bounds of the search for timed paths.

    Attributes
    ----------
    attempts : int
        Disassemblies that are tried.
    boats : int
        Attempts times boats that are enough: large structures take long, and are tried less often once there is a plan
        that is not poor.
    good_enough : int
        Steps beyond the longest straight way with which the search is content.
    """

    attempts: int = 24
    boats: int = 800
    good_enough: int = 0


def plan_timed_paths(
    problem: AssemblyProblem, dispatch: Dispatch, forest: CutForest, seed: int, limits: TimedLimits
) -> TimedPlan | None:
    """Return the shortest timed plan of several attempts, None if none succeeds.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    forest : CutForest
        Trees of the dispatched structure, which must be separable.
    seed : int
    limits : TimedLimits
    """
    best: TimedPlan | None = None
    has_ring = False
    wanted = dispatch.longest_travel(problem) + limits.good_enough
    enough = max(2, limits.boats // problem.target_count)
    for attempt, keeps_order in product(range(limits.attempts), (False, True)):
        if attempt >= enough and best is not None and best.paths.steps <= POOR * wanted:
            break
        if keeps_order and not has_ring:
            continue  # it is slower, and only called for where there was a ring
        weight = CUT_WEIGHTS[attempt % len(CUT_WEIGHTS)]
        manner = Manner(cut_weight=weight, keeps_order=keeps_order)
        disassembly = Disassembly(problem, dispatch, forest, manner, rng_for(seed, "disassembly", attempt))
        steps_max = best.paths.steps - 1 if best is not None else 4 * wanted + 20
        backward = _come_apart(problem, dispatch, disassembly, steps_max)
        has_ring = False
        if backward is None:
            continue
        paths = TimedPaths(_forward(problem, dispatch, backward))
        tree = tree_of((1 << problem.target_count) - 1, disassembly.cuts)
        has_ring = waits_in_ring(problem, dispatch, tree, paths)
        if not has_ring:
            best = TimedPlan(paths, tree)
            if paths.steps <= wanted:
                break
    return best


def _come_apart(
    problem: AssemblyProblem, dispatch: Dispatch, disassembly: Disassembly, steps_max: int
) -> IntArray | None:
    """Return the backward cells of the boats of all targets, (steps + 1, M, 2); None beyond `steps_max` steps."""
    if not disassembly.is_clear:
        return None
    while not disassembly.is_apart:
        if disassembly.expected_end > steps_max:
            return None
        disassembly.step()
    if disassembly.expected_end > steps_max:
        return None
    here: list[Cell] = [disassembly.lattice.cell(number) for number in disassembly.history[-1]]
    goals = [problem.starts[boat] for boat in dispatch.boats]
    idle = [*(problem.starts[boat] for boat in dispatch.idle(problem)), *problem.obstacles]
    homing = plan_homing(
        problem, idle, here, goals, HomingLimits(keeps_order=disassembly.keeps_order), disassembly.groups
    )
    if homing is None:
        return None
    backward = np.concatenate([_cells(disassembly), homing[1:]])
    return backward if len(backward) - 1 <= steps_max else None


def _cells(disassembly: Disassembly) -> IntArray:
    return np.array([[disassembly.lattice.cell(n) for n in row] for row in disassembly.history], dtype=np.int64)


def _forward(problem: AssemblyProblem, dispatch: Dispatch, backward: IntArray) -> IntArray:
    cells = np.repeat(np.array(problem.starts, dtype=np.int64)[None], len(backward), axis=0)
    cells[:, list(dispatch.boats)] = backward[::-1]
    return cells
