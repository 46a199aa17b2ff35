"""Of the dispatches that the tabu search found, the one of shortest ways along its guideposts is taken."""

from dataclasses import replace
from itertools import permutations

import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.selection import select
from mission_computer.assembly.structure import Structure
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, Guideposts, TreeNode, ways_home
from swarm_msgs_py.errors import AssemblyError, NoDispatchError

STARTS = [(2, 12), (13, 2), (24, 12)]


def test_boats_of_a_class_are_exchanged_until_their_ways_are_short() -> None:
    problem = problem_of(block(3, 1), [ALL_SIDES] * 3, starts=STARTS)

    chosen = {
        select(problem, Structure(problem.targets), [Dispatch(boats, (0, 0, 0))]).dispatch.boats
        for boats in permutations(range(3))
    }

    assert chosen == {(0, 1, 2)}


def test_the_longest_way_is_measured_along_the_guideposts() -> None:
    problem = problem_of(block(3, 1), [ALL_SIDES] * 3, starts=STARTS)

    best = select(problem, Structure(problem.targets), [Dispatch((0, 1, 2), (0, 0, 0))])

    assert best.rank[:2] == (10, 30)  # straight on all the way: guideposts lie on it
    behind = replace(problem, starts=((11, 12), (13, 10), (15, 12)))  # 2 cells from targets 12 and 14, 4 from the posts
    best = select(behind, Structure(problem.targets), [Dispatch((0, 1, 2), (0, 0, 0))])
    assert best.rank[0] == 5


def test_the_ways_home_add_up_along_the_tree() -> None:
    tree = AssemblyTree(
        (TreeNode((0, 1), -1, (1, 2), Axis.X, 12), TreeNode((0,), 0), TreeNode((1,), 0)),
    )

    assert ways_home(tree, Guideposts(((0, 0), (-3, 1), (0, 0)))) == [0, 4, 0]


def test_idle_boats_where_the_structure_is_put_together_are_told() -> None:
    bare = (0, 0, 0, 0)
    problem = problem_of(block(2, 1), [ALL_SIDES, ALL_SIDES, bare], starts=[(2, 12), (24, 12), (12, 11)])

    with pytest.raises(AssemblyError, match="idle boats lie where"):
        select(problem, Structure(problem.targets), [Dispatch((0, 1), (0, 0))])


def test_dispatches_that_no_straight_cut_takes_apart_are_refused() -> None:
    problem = problem_of(block(2, 1), [(1, 0, 0, 0)] * 2)  # turned away from each other

    with pytest.raises(NoDispatchError, match="none of 1 dispatches"):
        select(problem, Structure(problem.targets), [Dispatch((0, 1), (0, 0))])
