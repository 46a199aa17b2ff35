"""Whether a docked group holds together, judged from the contact foils of its boats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.assembly.plan import Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem


class CrewContacts:
    """The docks that the structure is to have.

    Parameters
    ----------
    problem : AssemblyProblem
    dispatch : Dispatch
    """

    def __init__(self, problem: AssemblyProblem, dispatch: Dispatch) -> None:
        wanted = docked_contacts(problem.targets, dispatch.layouts(problem), problem.gender)
        boats = dispatch.boats
        self._docks = [((boats[one.one], one.face), (boats[one.other], one.face.opposite)) for one in wanted]

    def is_connected(self, crew: Sequence[int], pressed: Mapping[int, frozenset[Face]]) -> bool:
        """Return whether the docks within a group that are known to be closed connect all of it.

        Parameters
        ----------
        crew : sequence of int
        pressed : mapping
            Sides of boats' cells whose foils are pressed; a dock is closed if either side says so.
        """
        if len(crew) == 1:
            return True
        members = set(crew)
        links: dict[int, list[int]] = {boat: [] for boat in crew}
        for (one, face), (other, other_face) in self._docks:
            is_closed = face in pressed.get(one, ()) or other_face in pressed.get(other, ())
            if is_closed and one in members and other in members:
                links[one].append(other)
                links[other].append(one)
        seen, border = {crew[0]}, [crew[0]]
        while border:
            fresh = [boat for boat in links[border.pop()] if boat not in seen]
            seen.update(fresh)
            border.extend(fresh)
        return len(seen) == len(members)
