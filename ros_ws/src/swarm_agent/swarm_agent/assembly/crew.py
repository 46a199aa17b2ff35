"""What a boat knows of the plan: its place in the tree, its partners, where groups wait and meet."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, Guideposts
from swarm_msgs_py.assembly.problem import AssemblyProblem


@dataclass(frozen=True, slots=True)
class Orders:
    """The plan as every boat holds it.

    Attributes
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    tree : AssemblyTree
    guideposts : Guideposts
    """

    problem: AssemblyProblem
    dispatch: Dispatch
    tree: AssemblyTree
    guideposts: Guideposts

    def places(self, node: int) -> tuple[Cell, ...]:
        """Return the cells of a node in the structure."""
        return tuple(self.problem.targets[target] for target in self.tree.nodes[node].targets)

    def cells(self, node: int, shift: Cell) -> list[Cell]:
        """Return the cells of a node that stands `shift` from its place in the structure."""
        dx, dy = shift
        return [(x + dx, y + dy) for x, y in self.places(node)]

    def crew(self, node: int) -> tuple[int, ...]:
        """Return the boats that make up a node, ascending."""
        return tuple(sorted(self.dispatch.boats[target] for target in self.tree.nodes[node].targets))

    def leader(self, node: int) -> int:
        """Return the boat that thinks for a node: the one of lowest number."""
        return self.crew(node)[0]

    def contains(self, node: int, part: int) -> bool:
        """Return whether `part` is `node` or lies below it in the tree."""
        while part > node:  # parents come before their children
            part = self.tree.nodes[part].parent
        return part == node

    def is_visitor(self, node: int) -> bool:
        """Return whether a node drives to its partner, instead of waiting for it."""
        parent = self.tree.nodes[node].parent
        return parent >= 0 and self.guideposts.shifts[node] != self.guideposts.shifts[parent]

    def approach(self, node: int) -> list[Cell]:
        """Return the shifts of a visitor on its straight way in, from its guidepost to where it docks."""
        parent = self.tree.nodes[node].parent
        (x, y), (u, v) = self.guideposts.shifts[node], self.guideposts.shifts[parent]
        if self.tree.nodes[parent].axis is Axis.X:
            step = 1 if u > x else -1
            return [(at, y) for at in range(x, u + step, step)]
        step = 1 if v > y else -1
        return [(x, at) for at in range(y, v + step, step)]
