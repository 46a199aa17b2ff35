"""The plan of an assembly: who goes where, in which order groups join, where they wait, and when they move."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.assembly.faces import Cell, Layout, turned
from swarm_msgs_py.assembly.problem import AssemblyProblem, manhattan
from swarm_msgs_py.types import IntArray


class Axis(Enum):
    """Normal of a cut, and so the direction in which its two parts join."""

    X = 0  # a vertical line; parts left and right of it
    Y = 1  # a horizontal line; parts below and above it


@dataclass(frozen=True, slots=True)
class Dispatch:
    """Which boat takes each target, and how it is turned.

    Attributes
    ----------
    boats : tuple of int
        Boat of each target.
    turns : tuple of int
        Clockwise quarter turns of that boat from its orientation at the start.
    """

    boats: tuple[int, ...]
    turns: tuple[int, ...]

    def layouts(self, problem: AssemblyProblem) -> tuple[Layout, ...]:
        """Return the turned layout at each target."""
        return tuple(turned(problem.layouts[b], t) for b, t in zip(self.boats, self.turns, strict=True))

    def idle(self, problem: AssemblyProblem) -> tuple[int, ...]:
        """Return the boats without a target."""
        return tuple(sorted(set(range(problem.boat_count)) - set(self.boats)))

    def total_travel(self, problem: AssemblyProblem) -> int:
        """Return the sum of all distances from start to target [cells]."""
        return sum(problem.travel(boat, target) for target, boat in enumerate(self.boats))

    def longest_travel(self, problem: AssemblyProblem) -> int:
        """Return the longest distance from start to target [cells]: no plan takes fewer steps."""
        return max(problem.travel(boat, target) for target, boat in enumerate(self.boats))


@dataclass(frozen=True, slots=True)
class TreeNode:
    """A part of the structure, and the straight line along which it is put together.

    Attributes
    ----------
    targets : tuple of int
        Its target numbers, ascending.
    parent : int
        Number of the node that it is a part of, -1 for the root.
    children : tuple of int
        Numbers of the parts below or left, and above or right of the line; empty for a single cell.
    axis : Axis or None
        Normal of the line; None for a single cell.
    line : int
        Last column or row of the first part.
    """

    targets: tuple[int, ...]
    parent: int
    children: tuple[int, ...] = ()
    axis: Axis | None = None
    line: int = 0


@dataclass(frozen=True, slots=True)
class AssemblyTree:
    """Binary tree of parts; node 0 is the structure, and parents come before their children."""

    nodes: tuple[TreeNode, ...]

    @property
    def depth(self) -> int:
        """Cuts on the longest way from the structure to a single cell."""
        levels = [0] * len(self.nodes)
        for number, node in enumerate(self.nodes):
            if node.parent >= 0:
                levels[number] = levels[node.parent] + 1
        return max(levels)

    def leaf_of(self) -> dict[int, int]:
        """Return the node without children that each target belongs to: a single boat, or a group docked before."""
        return {t: number for number, node in enumerate(self.nodes) if not node.children for t in node.targets}

    def sibling(self, number: int) -> int:
        """Return the node with which node `number` makes its parent, -1 for the root."""
        parent = self.nodes[number].parent
        if parent < 0:
            return -1
        low, high = self.nodes[parent].children
        return high if number == low else low


@dataclass(frozen=True, slots=True)
class Guideposts:
    """Where each part of the structure is put together before it joins the next: the extension.

    Attributes
    ----------
    shifts : tuple of Cell
        For each node of the tree, how far it stands from its place in the structure.
    """

    shifts: tuple[Cell, ...]


def ways_home(tree: AssemblyTree, posts: Guideposts) -> list[int]:
    """Return how far each node drives from its guidepost, in its own group and in larger ones, to the end [cells]."""
    ways = [0] * len(tree.nodes)
    for number, node in enumerate(tree.nodes[1:], start=1):  # parents come before their children
        ways[number] = ways[node.parent] + manhattan(posts.shifts[number], posts.shifts[node.parent])
    return ways


@dataclass(frozen=True, slots=True, eq=False)
class TimedPaths:
    """Where every boat is at every step.

    Attributes
    ----------
    cells : (steps + 1, n, 2) int array
        Column and row of each boat; the first row holds the starts. Boats without a target never move.
    """

    cells: IntArray

    @property
    def steps(self) -> int:
        """Steps from the start until the structure is complete."""
        return len(self.cells) - 1


@dataclass(frozen=True, slots=True, eq=False)
class AssemblyPlan:
    """What the mission computer hands to the boats.

    Attributes
    ----------
    dispatch : Dispatch
    tree : AssemblyTree
    guideposts : Guideposts or None
        For boats that find their ways by themselves.
    paths : TimedPaths or None
        For boats that follow timed guideposts.
    feasible : int
        How many dispatches that join the structure were found.
    """

    dispatch: Dispatch
    tree: AssemblyTree
    guideposts: Guideposts | None
    paths: TimedPaths | None
    feasible: int
