import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.extension import extend
from mission_computer.assembly.map_library import load_problem
from mission_computer.assembly.structure import Structure
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.plan import AssemblyTree
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError


def tree_with_all_docks(problem: AssemblyProblem) -> AssemblyTree:
    structure = Structure(problem.targets)
    tree = CutForest(structure, structure.contacts).tree()
    assert tree is not None
    return tree


@pytest.mark.parametrize("name", ["map_1", "map_2", "map_3", "map_4"])
def test_leaves_stand_the_interval_apart_along_the_cut_that_parted_them(name: str) -> None:
    problem = load_problem(name, Gender.GENDERLESS)
    tree = tree_with_all_docks(problem)
    shifts = extend(problem, tree).shifts
    leaf = tree.leaf_of()
    place = {
        target: tuple(problem.targets[target][axis] + shifts[leaf[target]][axis] for axis in (0, 1)) for target in leaf
    }

    for node in tree.nodes:
        if node.axis is None:
            continue
        low, high = (tree.nodes[child].targets for child in node.children)
        gaps = [place[b][node.axis.value] - place[a][node.axis.value] for a in low for b in high]
        assert min(gaps) >= 1 + problem.interval


@pytest.mark.parametrize("name", ["map_2", "map_4"])
def test_one_part_of_every_cut_stays_where_the_whole_is(name: str) -> None:
    problem = load_problem(name, Gender.GENDERLESS)
    tree = tree_with_all_docks(problem)
    shifts = extend(problem, tree).shifts

    assert shifts[0] == (0, 0)
    for number, node in enumerate(tree.nodes):
        if node.children:
            moved = [shifts[child] for child in node.children if shifts[child] != shifts[number]]
            assert len(moved) == 1


def test_a_grid_without_room_is_named() -> None:
    starts = [(1, 1), (3, 1), (5, 1), (7, 1)]
    problem = problem_of(block(4, 1, (1, 4)), [ALL_SIDES] * 4, size=(9, 9), starts=starts)

    with pytest.raises(AssemblyError, match="outside the grid of 9 x 9; enlarge the grid"):
        extend(problem, tree_with_all_docks(problem))
