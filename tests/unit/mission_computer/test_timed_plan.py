"""Timed paths: groups that keep the order of passing never wait for each other in a ring."""

from __future__ import annotations

import pytest

from mission_computer.assembly.cut_tree import tree_of
from mission_computer.assembly.disassembly import Disassembly, Manner
from mission_computer.assembly.dispatching import DispatchLimits, dispatches
from mission_computer.assembly.generated import Outline, generate_problem
from mission_computer.assembly.planner import forest_of
from mission_computer.assembly.structure import Structure
from mission_computer.assembly.timed_plan import TimedLimits, _come_apart, _forward, plan_timed_paths
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.plan import TimedPaths
from swarm_msgs_py.assembly.precedence import waits_in_ring
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.assembly import audit_assembly

SEED = 2
PROBLEM = generate_problem(Outline.BLOCK, 60, Gender.GENDERLESS, SEED)
STRUCTURE = Structure(PROBLEM.targets)
DISPATCH = next(dispatches(PROBLEM, STRUCTURE, SEED, DispatchLimits()))


@pytest.mark.parametrize("keeps_order", [False, True])
def test_groups_that_keep_their_order_move_up_in_no_ring(keeps_order: bool) -> None:
    forest = forest_of(PROBLEM, STRUCTURE, DISPATCH)
    manner = Manner(cut_weight=1.0, keeps_order=keeps_order)
    disassembly = Disassembly(PROBLEM, DISPATCH, forest, manner, rng_for(SEED + 1, "disassembly", 0))
    backward = _come_apart(PROBLEM, DISPATCH, disassembly, 200)
    assert backward is not None

    paths = TimedPaths(_forward(PROBLEM, DISPATCH, backward))
    tree = tree_of(STRUCTURE.whole, disassembly.cuts)

    assert audit_assembly(PROBLEM, DISPATCH, paths.cells).is_legal_and_complete
    assert waits_in_ring(PROBLEM, DISPATCH, tree, paths) != keeps_order


def test_a_plan_that_waits_in_a_ring_is_made_again_instead_of_given_up() -> None:
    forest = forest_of(PROBLEM, STRUCTURE, DISPATCH)

    plan = plan_timed_paths(PROBLEM, DISPATCH, forest, SEED + 1, TimedLimits(attempts=2))

    assert plan is not None
    assert not waits_in_ring(PROBLEM, DISPATCH, plan.tree, plan.paths)
