from itertools import product

import pytest
from assembly_problems import block

from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.structure import Structure, members
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.plan import Axis

PINWHEEL = [(2, 1), (3, 1), (4, 2), (4, 3), (3, 4), (2, 4), (1, 3), (1, 2), (2, 2), (3, 2), (2, 3), (3, 3), (1, 1)]


def separable_by_enumeration(cells: frozenset[tuple[int, int]], docked: set[frozenset[tuple[int, int]]]) -> bool:
    """Return whether straight cuts, each across a docked contact, take the cells apart: the obvious recursion."""
    if len(cells) == 1:
        return True
    for axis, line in product((0, 1), range(-1, 30)):
        low = frozenset(cell for cell in cells if cell[axis] <= line)
        high = cells - low
        crossed = low and high and any(one & low and one & high for one in docked if one <= cells)
        if crossed and separable_by_enumeration(low, docked) and separable_by_enumeration(high, docked):
            return True
    return False


def test_a_block_is_halved_until_single_cells_are_left() -> None:
    structure = Structure(block(4, 2))
    tree = CutForest(structure, structure.contacts).tree()

    assert tree is not None
    assert tree.depth == 3
    assert tree.nodes[0].axis is Axis.Y  # as even as across, and more contacts join there
    assert [len(tree.nodes[child].targets) for child in tree.nodes[0].children] == [4, 4]
    assert sorted(node.targets for node in tree.nodes if not node.children) == [(target,) for target in range(8)]


def test_children_share_out_their_parents_targets() -> None:
    structure = Structure(PINWHEEL)
    tree = CutForest(structure, structure.contacts).tree()

    assert tree is not None
    for node in tree.nodes:
        if node.children:
            parts = [tree.nodes[child].targets for child in node.children]
            assert sorted(parts[0] + parts[1]) == list(node.targets)


def test_a_cut_that_no_dock_crosses_is_not_made() -> None:
    structure = Structure(block(2, 2))
    upright = [contact for contact in structure.contacts if contact.face.name == "UP"]
    across = [contact for contact in structure.contacts if contact.face.name == "RIGHT"]

    tree = CutForest(structure, [*upright, across[0]]).tree()

    assert tree is not None
    assert tree.nodes[0].axis is Axis.X  # a level cut would leave two boats that nothing joins


def test_two_undocked_pieces_have_no_tree() -> None:
    structure = Structure(block(2, 2))
    upright = [contact for contact in structure.contacts if contact.face.name == "UP"]

    assert CutForest(structure, upright).tree() is None


@pytest.mark.parametrize("pattern", range(64))
def test_separability_agrees_with_enumeration(pattern: int) -> None:
    cells = block(3, 2)
    structure = Structure(cells)
    spread = pattern * 0x9E3779B1 >> 7  # 64 docking patterns of the seven contacts
    docked: list[Contact] = [one for n, one in enumerate(structure.contacts) if spread >> n & 1]
    named = {frozenset((cells[one.one], cells[one.other])) for one in docked}

    assert CutForest(structure, docked).is_separable(structure.whole) == separable_by_enumeration(
        frozenset(cells), named
    )


def test_the_least_depth_of_a_row_of_eight_is_three() -> None:
    structure = Structure(block(8, 1))

    assert CutForest(structure, structure.contacts).least_depth(structure.whole) == 3


def test_every_valid_cut_parts_the_targets() -> None:
    structure = Structure(PINWHEEL)
    forest = CutForest(structure, structure.contacts)

    for cut in forest.valid_cuts(structure.whole):
        assert sorted(members(cut.low) + members(cut.high)) == list(range(len(PINWHEEL)))
