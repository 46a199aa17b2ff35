"""Stage II: the structure cut by straight lines into single cells (algorithm 2, eq. 29 of the paper).

Each cut must be crossed by at least one docked contact, because the two parts join by it later. A part all of whose
cuts fail further down is no part of a tree: the search then backtracks to another cut of its parent. Every part of a
tree is the structure within a rectangle, so that at most O(W^2 H^2) parts are ever looked at, each once.
"""

from __future__ import annotations

from collections.abc import Sequence

from mission_computer.assembly.structure import Cut, Part, Structure, members
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, TreeNode


class CutForest:
    """All trees of a structure whose contacts are docked or not.

    Parameters
    ----------
    structure : Structure
    docked : sequence of Contact
        The contacts that are docked.
    """

    def __init__(self, structure: Structure, docked: Sequence[Contact]) -> None:
        self._structure = structure
        self._docked = frozenset(docked)
        self._first: dict[Part, Cut | None] = {}
        self._all: dict[Part, tuple[Cut, ...]] = {}
        self._depth: dict[Part, int] = {}

    def is_separable(self, part: Part) -> bool:
        """Return whether some tree of cuts takes `part` down to its atoms."""
        return self._structure.is_atom(part) or self.best_cut(part) is not None

    def best_cut(self, part: Part) -> Cut | None:
        """Return the cut of eq. (29): the most even one whose two parts are separable, None if there is none.

        Of equally even cuts, the one that more docked contacts cross; then the first.
        """
        if part not in self._first:
            ranked = sorted(
                ((cut, count) for cut in self._structure.cuts(part) if (count := self.docked_across(part, cut))),
                key=lambda one: (-one[0].low.bit_count() * one[0].high.bit_count(), -one[1]),
            )
            self._first[part] = next((cut for cut, _ in ranked if self._parts_separable(cut)), None)
        return self._first[part]

    def valid_cuts(self, part: Part) -> tuple[Cut, ...]:
        """Return every cut that begins some tree of `part`, x before y, ascending."""
        if part not in self._all:
            self._all[part] = tuple(
                cut
                for cut in self._structure.cuts(part)
                if self.docked_across(part, cut) and self._parts_separable(cut)
            )
        return self._all[part]

    def least_depth(self, part: Part) -> int:
        """Return the depth of the shallowest tree of a separable part."""
        if self._structure.is_atom(part):
            return 0
        if part not in self._depth:
            self._depth[part] = 1 + min(
                max(self.least_depth(cut.low), self.least_depth(cut.high)) for cut in self.valid_cuts(part)
            )
        return self._depth[part]

    def docked_across(self, part: Part, cut: Cut) -> int:
        """Return how many docked contacts of `part` cross a cut."""
        return sum(contact in self._docked for contact in self._structure.crossing(part, cut))

    def tree(self) -> AssemblyTree | None:
        """Return the tree of best cuts of the whole structure, None if it is not separable."""
        whole = self._structure.whole
        if not self.is_separable(whole):
            return None
        chosen: dict[Part, Cut] = {}
        parts = [whole]
        while parts:
            part = parts.pop()
            cut = self.best_cut(part) if not self._structure.is_atom(part) else None
            if cut is not None:
                chosen[part] = cut
                parts += [cut.low, cut.high]
        return tree_of(whole, chosen)

    def is_atom(self, part: Part) -> bool:
        """Return whether a part comes apart no further."""
        return self._structure.is_atom(part)

    @property
    def atom_count(self) -> int:
        """Groups that the structure is put together from."""
        return self._structure.atom_count

    def _parts_separable(self, cut: Cut) -> bool:
        return self.is_separable(cut.low) and self.is_separable(cut.high)


def tree_of(whole: Part, chosen: dict[Part, Cut]) -> AssemblyTree:
    """Return the tree in which each part of several cells is cut as `chosen`; parts are numbered breadth first."""
    queue: list[tuple[Part, int]] = [(whole, -1)]
    nodes: list[TreeNode] = []
    for part, parent in queue:  # grows while it is read
        cut = chosen.get(part)
        if cut is None:
            nodes.append(TreeNode(members(part), parent))
            continue
        children = (len(queue), len(queue) + 1)
        queue += [(cut.low, len(nodes)), (cut.high, len(nodes))]
        nodes.append(TreeNode(members(part), parent, children, Axis(cut.axis), cut.line))
    return AssemblyTree(tuple(nodes))
