"""Geometry of a structure as bit sets: parts of it, straight lines through it, contacts across them.

A part is a Python integer whose bit t stands for target t; sets of any size, and all that stage II does, are then a few
machine operations.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from swarm_msgs_py.assembly.docking import Contact, contacts
from swarm_msgs_py.assembly.faces import Cell, Face
from swarm_msgs_py.assembly.plan import Axis

Part = int
"""Set of targets, as bits."""


@dataclass(frozen=True, slots=True)
class Cut:
    """A straight line through a part.

    Attributes
    ----------
    axis : Axis
        Its normal.
    line : int
        Last column or row of `low`.
    low, high : Part
        What lies left or below, and right or above.
    """

    axis: Axis
    line: int
    low: Part
    high: Part


class Structure:
    """Cells of a structure with their lines and contacts.

    Parameters
    ----------
    cells : sequence of Cell
        Targets in order.
    atoms : sequence of Part
        Parts that are docked already, and are not to be cut; every other target is an atom of its own.
    """

    def __init__(self, cells: Sequence[Cell], atoms: Sequence[Part] = ()) -> None:
        self.cells = tuple(cells)
        self._atoms = tuple(atoms)
        self.contacts = contacts(cells)
        self.whole: Part = (1 << len(self.cells)) - 1
        self._below = {
            axis: {
                line: part_of(t for t, cell in enumerate(cells) if cell[axis.value] <= line)
                for line in range(min(c[axis.value] for c in cells), max(c[axis.value] for c in cells))
            }
            for axis in Axis
        }
        self._neighbors = [0] * len(self.cells)
        self._crossing: dict[tuple[Axis, int], list[Contact]] = {}
        for contact in self.contacts:
            self._neighbors[contact.one] |= 1 << contact.other
            self._neighbors[contact.other] |= 1 << contact.one
            self._crossing.setdefault(self._line_of(contact), []).append(contact)

    def cuts(self, part: Part) -> Iterator[Cut]:
        """Yield every line that divides `part` and no atom of it, x before y, ascending."""
        if self.is_atom(part):
            return
        for axis, lines in self._below.items():
            for line, below in lines.items():
                low = part & below
                if (
                    low
                    and low != part
                    and not any(atom & part & below and atom & part & ~below for atom in self._atoms)
                ):
                    yield Cut(axis, line, low, part & ~below)

    def is_atom(self, part: Part) -> bool:
        """Return whether a part is a single target, or docked already."""
        return part & (part - 1) == 0 or part in self._atoms

    @property
    def atom_count(self) -> int:
        """Atoms that the structure is put together from."""
        return len(self.cells) - sum(atom.bit_count() - 1 for atom in self._atoms)

    def crossing(self, part: Part, cut: Cut) -> list[Contact]:
        """Return the contacts of `part` that a cut parts."""
        return [
            contact
            for contact in self._crossing.get((cut.axis, cut.line), ())
            if part >> contact.one & 1 and part >> contact.other & 1
        ]

    def is_connected(self, part: Part) -> bool:
        """Return whether a part that is not empty holds together by its cells' sides."""
        reached = part & -part
        border = reached
        while border:
            bit = border & -border
            border ^= bit
            fresh = self._neighbors[bit.bit_length() - 1] & part & ~reached
            reached |= fresh
            border |= fresh
        return reached == part

    def _line_of(self, contact: Contact) -> tuple[Axis, int]:
        axis = Axis.X if contact.face is Face.RIGHT else Axis.Y
        return axis, self.cells[contact.one][axis.value]


def part_of(targets: Iterable[int]) -> Part:
    """Return the part that holds these targets."""
    part = 0
    for target in targets:
        part |= 1 << target
    return part


def members(part: Part) -> tuple[int, ...]:
    """Return the targets of a part, ascending."""
    found = []
    while part:
        bit = part & -part
        found.append(bit.bit_length() - 1)
        part ^= bit
    return tuple(found)
