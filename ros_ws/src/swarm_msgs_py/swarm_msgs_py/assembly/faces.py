"""Docking mechanisms of a square boat: which sides carry one, how a turn permutes them, which sides join.

A *layout* gives the mechanism on each side of a boat in the order of `Face`: 0 for none, 1 or 2 for its type. Without
genders, the only type is 1 and two equipped sides join. With opposite genders, type 1 joins type 2 and nothing else:
sides of the same gender may touch, and repel each other.
"""

from __future__ import annotations

from enum import Enum, IntEnum
from functools import lru_cache
from typing import Final

Cell = tuple[int, int]
"""Column and row of a grid cell: x grows to the right, y upward."""

Layout = tuple[int, int, int, int]
"""Mechanism on each side, in the order of `Face`: 0 none, 1 or 2 its type."""


class Face(IntEnum):
    """Side of a boat, or of a cell; the value is its place in a layout."""

    UP = 0
    DOWN = 1
    LEFT = 2
    RIGHT = 3

    @property
    def opposite(self) -> Face:
        """The side that meets this one."""
        return Face(self ^ 1)

    @property
    def offset(self) -> Cell:
        """Step to the cell beyond this side."""
        return OFFSETS[self]


OFFSETS: Final[tuple[Cell, ...]] = ((0, 1), (0, -1), (-1, 0), (1, 0))
"""Step to the neighboring cell beyond each side, in the order of `Face`."""

_CLOCKWISE: Final = {Face.UP: Face.RIGHT, Face.RIGHT: Face.DOWN, Face.DOWN: Face.LEFT, Face.LEFT: Face.UP}

QUARTER_TURNS: Final = 4
"""Quarter turns in a full turn."""


class Gender(Enum):
    """Which mechanisms join."""

    GENDERLESS = "genderless"  # any two
    OPPOSITE = "gendered"  # type 1 with type 2 only

    @property
    def types(self) -> tuple[int, ...]:
        """Values that a side may have."""
        return (0, 1) if self is Gender.GENDERLESS else (0, 1, 2)

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """Ordered pairs of side values that join."""
        return ((1, 1),) if self is Gender.GENDERLESS else ((1, 2), (2, 1))

    def joins(self, one: int, other: int) -> bool:
        """Return whether two sides that meet connect."""
        return one * other == (1 if self is Gender.GENDERLESS else 2)


def turned(layout: Layout, quarter_turns: int) -> Layout:
    """Return a boat's layout after clockwise quarter turns: what looked left looks up then."""
    for _ in range(quarter_turns % QUARTER_TURNS):
        up, down, left, right = layout
        layout = (left, right, down, up)
    return layout


def turned_face(face: Face, quarter_turns: int) -> Face:
    """Return where a side of a boat looks after clockwise quarter turns."""
    for _ in range(quarter_turns % QUARTER_TURNS):
        face = _CLOCKWISE[face]
    return face


@lru_cache(maxsize=1024)
def distinct_turns(layout: Layout) -> tuple[int, ...]:
    """Return the least quarter turns that lead to each distinct orientation of a layout, ascending, 0 first."""
    seen: dict[Layout, int] = {}
    for quarter_turns in range(QUARTER_TURNS):
        seen.setdefault(turned(layout, quarter_turns), quarter_turns)
    return tuple(seen.values())


def layout_class(layout: Layout) -> Layout:
    """Return the representative of all layouts that are turns of one another."""
    return min(turned(layout, quarter_turns) for quarter_turns in range(QUARTER_TURNS))
