"""Which neighbors in a structure are docked: connectivity always means through mechanisms that join."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from swarm_msgs_py.assembly.faces import Cell, Face, Gender, Layout
from swarm_msgs_py.assembly.problem import AssemblyProblem, neighbors

_FORWARD = (Face.UP, Face.RIGHT)  # of each pair of neighbors, the lower or left one names it


@dataclass(frozen=True, slots=True)
class Contact:
    """Two neighboring cells of a structure.

    Attributes
    ----------
    one, other : int
        Target numbers.
    face : Face
        Side of `one` that meets `other`: up or right.
    """

    one: int
    other: int
    face: Face


def contacts(cells: Sequence[Cell]) -> tuple[Contact, ...]:
    """Return all pairs of neighbors among `cells`, ordered by the first, then by the side."""
    number = {cell: index for index, cell in enumerate(cells)}
    return tuple(
        Contact(number[cell], number[beyond], face)
        for cell in cells
        for face in _FORWARD
        if (beyond := neighbors(cell)[face]) in number
    )


def is_docked(contact: Contact, layouts: Sequence[Layout], gender: Gender) -> bool:
    """Return whether the mechanisms at a contact join, given each target's layout."""
    return gender.joins(layouts[contact.one][contact.face], layouts[contact.other][contact.face.opposite])


def docked_contacts(cells: Sequence[Cell], layouts: Sequence[Layout], gender: Gender) -> tuple[Contact, ...]:
    """Return the contacts that are docked, in the order of `contacts`."""
    return tuple(contact for contact in contacts(cells) if is_docked(contact, layouts, gender))


def docked_groups(placed: Mapping[Cell, Layout], gender: Gender) -> list[set[Cell]]:
    """Return the docked groups of boats at `placed` cells, in the order of their least cell."""
    left = set(placed)
    groups = []
    for first in sorted(placed):
        if first not in left:
            continue
        left.remove(first)
        group, border = {first}, [first]
        while border:
            cell = border.pop()
            for face in Face:
                beyond = neighbors(cell)[face]
                if beyond in left and gender.joins(placed[cell][face], placed[beyond][face.opposite]):
                    left.remove(beyond)
                    group.add(beyond)
                    border.append(beyond)
        groups.append(group)
    return groups


def same_gender_contacts(problem: AssemblyProblem, layouts: Sequence[Layout]) -> int:
    """Return how many contacts have equipped sides that do not join: they repel each other."""
    return sum(
        layouts[contact.one][contact.face] > 0
        and layouts[contact.other][contact.face.opposite] > 0
        and not is_docked(contact, layouts, problem.gender)
        for contact in contacts(problem.targets)
    )
