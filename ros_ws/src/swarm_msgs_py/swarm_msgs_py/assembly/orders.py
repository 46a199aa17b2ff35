"""What the mission computer orders the boats, as a radio frame: a plan, or to stop at the next cell.

Boats follow a plan with timed paths; with guideposts alone they find their ways by themselves.

Layout of a frame, little-endian: version u8 | kind u8 | epoch u16, and for a plan, compressed::

    origin 2 i16 | size 2 u16 | boats u16 | targets u16 | steps u16 | nodes u16 | gender u8
    targets, starts: 2 i16 each | layouts u8 each, two bits per side | boat of each target u16 | its turns u8
    parent of each node i16 | children of each node 2 u16 | axis u8 | line i16 | leaf of each target u16
    timed: moves u8, of each target for each step; guided, with 0 steps: shift of each node 2 i16

The plan is that of one epoch, complete: who has heard it needs nothing else.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from swarm_msgs_py.assembly.faces import OFFSETS, Face, Gender, Layout
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, Guideposts, TimedPaths, TreeNode
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.binary import Reader, packed, packed_integers
from swarm_msgs_py.errors import AssemblyError, FrameError
from swarm_msgs_py.types import IntArray

ORDER_VERSION = 0x92
"""First byte of an order; progress frames begin with another."""
_HEAD = struct.Struct("<BBH")
_PLAN = struct.Struct("<2h2H4HB")
_STOP, _FOLLOW, _FIND = 0, 1, 2
_GENDERS = tuple(Gender)
_LAYOUT_BITS = 2
_OFFSETS = np.array([(0, 0), *OFFSETS])
PLAN_BYTES_MAX = 1_000_000
"""Of a plan that was unpacked; more is no plan."""


@dataclass(frozen=True, slots=True, eq=False)
class TimedOrders:
    """A plan as every boat holds it.

    Attributes
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    tree : AssemblyTree
    paths : TimedPaths
    epoch : int
        Number of the plan, from 1.
    """

    problem: AssemblyProblem
    dispatch: Dispatch
    tree: AssemblyTree
    paths: TimedPaths
    epoch: int


@dataclass(frozen=True, slots=True, eq=False)
class GuidedOrders:
    """A plan by which every boat finds its way by itself.

    Attributes
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    tree : AssemblyTree
    guideposts : Guideposts
    epoch : int
        Number of the plan, from 1.
    """

    problem: AssemblyProblem
    dispatch: Dispatch
    tree: AssemblyTree
    guideposts: Guideposts
    epoch: int


PlanOrders = TimedOrders | GuidedOrders
"""A plan as every boat holds it."""


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What the mission computer wants.

    Attributes
    ----------
    epoch : int
        Number of the plan that it is about.
    plan : TimedOrders or GuidedOrders or None
        None to stop the one of this number, each boat at its next cell.
    """

    epoch: int
    plan: PlanOrders | None


def is_order(data: bytes) -> bool:
    """Return whether a frame says that it is an order."""
    return data[:1] == bytes([ORDER_VERSION])


def encode_order(order: Order) -> bytes:
    """Return the frame of an order.

    Raises
    ------
    FrameError
        If a number does not fit its place.
    """
    if order.plan is None:
        return packed(_HEAD, ORDER_VERSION, _STOP, order.epoch)
    kind = _FOLLOW if isinstance(order.plan, TimedOrders) else _FIND
    return packed(_HEAD, ORDER_VERSION, kind, order.epoch) + zlib.compress(_encode_plan(order.plan))


@lru_cache(maxsize=16)
def decode_order(data: bytes) -> Order:
    """Return the order that a frame stands for.

    Raises
    ------
    FrameError
        If `data` is not exactly one order.
    """
    reader = Reader(data)
    version, kind, epoch = reader.fields(_HEAD)
    if version != ORDER_VERSION or kind not in (_STOP, _FOLLOW, _FIND):
        raise FrameError("not an order to assembling boats")
    if kind == _STOP:
        reader.finish()
        return Order(epoch, None)
    unpacker = zlib.decompressobj()
    try:
        plain = unpacker.decompress(reader.rest(), PLAN_BYTES_MAX)
    except zlib.error as error:
        raise FrameError(f"an order that cannot be unpacked ({error})") from None
    if not unpacker.eof or unpacker.unused_data:
        raise FrameError("an order that is cut short or goes on")
    try:
        return Order(epoch, _decode_plan(Reader(plain), epoch, is_timed=kind == _FOLLOW))
    except (AssemblyError, ValueError, IndexError) as error:
        raise FrameError(f"an order that is no plan ({error})") from None


def _encode_plan(plan: PlanOrders) -> bytes:
    problem, dispatch, nodes = plan.problem, plan.dispatch, plan.tree.nodes
    leaves = plan.tree.leaf_of()
    if isinstance(plan, TimedOrders):
        steps = plan.paths.steps
        rest: tuple[Any, str] = (_moves(plan.paths.cells[:, list(dispatch.boats)]), "u1")
    else:
        steps, rest = 0, (plan.guideposts.shifts, "<i2")
    sizes = problem.boat_count, problem.target_count, steps, len(nodes)
    head = packed(_PLAN, *problem.origin, *problem.size, *sizes, _GENDERS.index(problem.gender))
    layouts = [sum(side << (_LAYOUT_BITS * face) for face, side in enumerate(layout)) for layout in problem.layouts]
    parts = (
        (problem.targets, "<i2"),
        (problem.starts, "<i2"),
        (layouts, "u1"),
        (dispatch.boats, "<u2"),
        (dispatch.turns, "u1"),
        ([node.parent for node in nodes], "<i2"),
        ([node.children or (0, 0) for node in nodes], "<u2"),
        ([node.axis.value if node.axis else 0 for node in nodes], "u1"),
        ([node.line for node in nodes], "<i2"),
        ([leaves[target] for target in range(problem.target_count)], "<u2"),
        rest,
    )
    return head + b"".join(packed_integers(values, dtype) for values, dtype in parts)


def _decode_plan(reader: Reader, epoch: int, *, is_timed: bool) -> PlanOrders:
    x, y, columns, rows, boats, targets, steps, nodes, gender = reader.fields(_PLAN)
    cells = [tuple((pair[0], pair[1]) for pair in _pairs(reader, "<i2", count)) for count in (targets, boats)]
    layouts = tuple(_layout(code) for code in reader.array("u1", boats).tolist())
    dispatch = Dispatch(tuple(reader.array("<u2", targets).tolist()), tuple(reader.array("u1", targets).tolist()))
    parents = reader.array("<i2", nodes).tolist()
    children = _pairs(reader, "<u2", nodes)
    axes, lines = reader.array("u1", nodes).tolist(), reader.array("<i2", nodes).tolist()
    leaves = reader.array("<u2", targets).tolist()
    moves = reader.array("u1", steps * targets).reshape(steps, targets).astype(np.int64)
    shifts = [] if is_timed else _pairs(reader, "<i2", nodes)
    reader.finish()
    if gender >= len(_GENDERS) or len(set(dispatch.boats)) < targets or max(dispatch.boats, default=0) >= boats:
        raise FrameError("an order whose dispatch is none")
    problem = AssemblyProblem(
        name="order",
        origin=(x, y),
        size=(columns, rows),
        targets=cells[0],
        starts=cells[1],
        layouts=layouts,
        gender=_GENDERS[gender],
        center=(x, y),
        is_midway=True,
    )
    tree = _tree(parents, children, axes, lines, leaves)
    if not is_timed:
        posts = Guideposts(tuple((pair[0], pair[1]) for pair in shifts))
        return GuidedOrders(problem, dispatch, tree, posts, epoch)
    paths = np.repeat(np.array(problem.starts, dtype=np.int64)[None], steps + 1, axis=0)
    paths[1:, list(dispatch.boats)] += np.cumsum(_OFFSETS[moves], axis=0)
    return TimedOrders(problem, dispatch, tree, TimedPaths(paths), epoch)


def _tree(
    parents: list[int], children: list[list[int]], axes: list[int], lines: list[int], leaves: list[int]
) -> AssemblyTree:
    targets: list[list[int]] = [[] for _ in parents]
    for target, leaf in enumerate(leaves):
        targets[leaf].append(target)
    for number in range(len(parents) - 1, 0, -1):  # children before their parents
        if not 0 <= parents[number] < number:
            raise FrameError("an order whose tree is none")
        targets[parents[number]] += targets[number]
    nodes = []
    for number, (parent, pair) in enumerate(zip(parents, children, strict=True)):
        if pair == [0, 0]:
            nodes.append(TreeNode(tuple(sorted(targets[number])), parent))
            continue
        if any(parents[child] != number for child in pair):
            raise FrameError("an order whose tree is none")
        low, high = pair
        nodes.append(TreeNode(tuple(sorted(targets[number])), parent, (low, high), Axis(axes[number]), lines[number]))
    return AssemblyTree(tuple(nodes))


def _moves(cells: IntArray) -> IntArray:
    """Return the move of each boat in each step, (steps, m), as values of `Move`."""
    steps = np.diff(cells, axis=0)
    moves = np.zeros(steps.shape[:2], dtype=np.int64)
    for face, offset in enumerate(OFFSETS):
        moves[(steps == offset).all(axis=2)] = face + 1
    return moves


def _pairs(reader: Reader, dtype: str, count: int) -> list[list[int]]:
    pairs: list[list[int]] = reader.array(dtype, 2 * count).astype(np.int64).reshape(-1, 2).tolist()
    return pairs


def _layout(code: int) -> Layout:
    up, down, left, right = ((code >> (_LAYOUT_BITS * face)) & 3 for face in Face)
    return up, down, left, right
