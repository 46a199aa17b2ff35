"""Generated assembly problems of any size that are known to have a solution: for scaling tests and benchmarks."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from mission_computer.assembly.cut_tree import CutForest
from mission_computer.assembly.structure import Structure, part_of
from swarm_msgs_py.assembly.docking import Contact
from swarm_msgs_py.assembly.faces import QUARTER_TURNS, Cell, Gender, Layout, turned
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.assembly.problem_file import nearest_to_centroid
from swarm_msgs_py.randomness import rng_for

SPARE_SHARE = 0.1
"""Boats beyond the targets, as a share of the targets."""

START_PITCH = 4
"""Cells from one start to the next: boats can pass between two that stay, as the extension leaves room, too."""

MORE_DOCKS = 0.55
"""Chance that a contact which the tree of cuts does not need is equipped: about 2.8 sides per boat, as on map 4."""


RING_THICKNESS = 3
"""Cells across the bars of a ring."""


class Outline(Enum):
    """What a generated structure looks like."""

    BLOCK = "block"  # filled, nearly square
    RING = "ring"  # a square frame, three cells thick
    CROSS = "cross"  # two bars, a fifth of the length thick


def generate_problem(outline: Outline, target_count: int, gender: Gender, seed: int) -> AssemblyProblem:
    """Return a problem whose random layouts allow a separable dispatch.

    The structure is equipped first, so that every cut of its most even tree is docked; then the boats are shuffled and
    turned at random, and placed around the structure, row behind row.

    Parameters
    ----------
    outline : Outline
    target_count : int
        Cells of the structure, >= 1.
    gender : Gender
    seed : int
    """
    rng = rng_for(seed, "generated", outline.value, target_count, gender.value)
    shape = sorted(_cells(outline, target_count))
    layouts = _layouts(shape, gender, rng)
    types = gender.types[1:]
    for _ in range(math.ceil(SPARE_SHARE * target_count)):
        sides = rng.integers(0, 2, size=4)
        sides[rng.integers(4)] = 1
        up, down, left, right = (int(side) * types[int(rng.integers(len(types)))] for side in sides)
        layouts.append((up, down, left, right))
    order = rng.permutation(len(layouts)).tolist()
    turns = rng.integers(0, QUARTER_TURNS, size=len(layouts)).tolist()
    starts, side = _starts(shape, len(layouts))
    low = 1 - min(min(cell) for cell in starts) + 1  # one free column and row beyond the outermost starts
    targets = tuple((x + low, y + low) for x, y in shape)
    return AssemblyProblem(
        name=f"{outline.value}-{target_count}-{seed}",
        origin=(1, 1),
        size=(side + 2, side + 2),
        targets=targets,
        starts=tuple((x + low, y + low) for x, y in starts),
        layouts=tuple(turned(layouts[boat], turn) for boat, turn in zip(order, turns, strict=True)),
        gender=gender,
        center=nearest_to_centroid(targets),
    )


def _cells(outline: Outline, count: int) -> list[Cell]:
    """Return `count` cells in rows from below; outlines are cut off at the top right where the count asks for it."""
    size = 1
    while len(cells := _outline(outline, size)) < count:
        size += 1
    # Whole rows are taken from below; within the last row from the left: what is left stays in one piece.
    rows = sorted(cells, key=lambda cell: (cell[1], cell[0]))
    return rows[:count]


def _outline(outline: Outline, size: int) -> list[Cell]:
    bar = max(1, size // 5)
    cells = [(x, y) for x in range(size) for y in range(size)]
    if outline is Outline.RING:
        return [(x, y) for x, y in cells if min(x, y, size - 1 - x, size - 1 - y) < RING_THICKNESS]
    if outline is Outline.CROSS:
        return [(x, y) for x, y in cells if min(abs(2 * x - size + 1), abs(2 * y - size + 1)) <= bar]
    return cells


def _layouts(shape: list[Cell], gender: Gender, rng: np.random.Generator) -> list[Layout]:
    structure = Structure(shape)
    sides = [[0, 0, 0, 0] for _ in shape]
    tree = CutForest(structure, structure.contacts).tree()
    needed: set[Contact] = set()
    for node in tree.nodes if tree is not None else ():
        if node.children and node.axis is not None:
            part = part_of(node.targets)
            cut = next(cut for cut in structure.cuts(part) if (cut.axis, cut.line) == (node.axis, node.line))
            crossing = structure.crossing(part, cut)
            needed.add(crossing[int(rng.integers(len(crossing)))])
    for contact in structure.contacts:
        if contact in needed or rng.random() < MORE_DOCKS:
            one, other = gender.pairs[int(rng.integers(len(gender.pairs)))]
            sides[contact.one][contact.face] = one
            sides[contact.other][contact.face.opposite] = other
    return [(up, down, left, right) for up, down, left, right in sides]


def _starts(shape: list[Cell], count: int) -> tuple[list[Cell], int]:
    """Return start cells on squares around the structure, and the side of the outermost square."""
    width = max(at for cell in shape for at in cell) + 1
    margin = START_PITCH + width // 2
    starts: list[Cell] = []
    while len(starts) < count:
        low, high = -margin, width - 1 + margin
        steps = range(low, high - START_PITCH + 1, START_PITCH)
        ring = [(at, low) for at in steps] + [(high, at) for at in steps]
        ring += [(low + high - at, high) for at in steps] + [(low, low + high - at) for at in steps]
        missing = count - len(starts)
        if len(ring) > missing:  # spread over the whole square
            ring = [ring[place * len(ring) // missing] for place in range(missing)]
        starts += ring
        margin += START_PITCH
    return starts, 2 * (margin - START_PITCH) + width
