"""Stage III: the structure pulled apart, so that boats and groups find room to meet (algorithm 3, eqs. 30-31).

From the root of the tree down, the part of each cut that does not hold the center moves away from it along the normal
of the cut; the other part stays. The distance is the interval times the columns (rows) from the center to the part, so
that in the end neighbors stand the same number of free cells apart, whichever order they were parted in.

The part that moves gets a center of its own: the old one, moved to the part's side of the line. The paper takes the
part's cell that is nearest to the old center. Around a hole, that cell may lie farther back than the line, and parts of
both sides would be sent to the same place.
"""

from __future__ import annotations

from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.plan import AssemblyTree, Guideposts
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError


def extend(problem: AssemblyProblem, tree: AssemblyTree) -> Guideposts:
    """Return where each part of the structure is put together.

    Raises
    ------
    AssemblyError
        If a guidepost would lie outside the grid; says how much room is missing.
    """
    count = len(tree.nodes)
    shifts: list[Cell] = [(0, 0)] * count
    centers: list[Cell] = [problem.center] * count
    for number, node in enumerate(tree.nodes):
        if node.axis is None:
            continue
        axis, line, center = node.axis.value, node.line, centers[number]
        holds_low = center[axis] <= line
        for child, is_low in zip(node.children, (True, False), strict=True):
            x, y = shifts[number]
            u, v = center
            if is_low != holds_low:
                edge = line if is_low else line + 1
                distance = problem.interval * (edge - center[axis])  # signed: away from the center
                x, y = (x + distance, y) if axis == 0 else (x, y + distance)
                u, v = (edge, v) if axis == 0 else (u, edge)
            shifts[child] = (x, y)
            centers[child] = (u, v)
    _check_room(problem, tree, shifts)
    return Guideposts(tuple(shifts))


def _check_room(problem: AssemblyProblem, tree: AssemblyTree, shifts: list[Cell]) -> None:
    for node, (dx, dy) in zip(tree.nodes, shifts, strict=True):
        for target in node.targets:
            x, y = problem.targets[target]
            if not problem.contains((x + dx, y + dy)):
                raise AssemblyError(
                    f"{problem.name}: the extension needs cell {(x + dx, y + dy)}, which is outside the grid of"
                    f" {problem.size[0]} x {problem.size[1]}; enlarge the grid or move the extension center"
                )
