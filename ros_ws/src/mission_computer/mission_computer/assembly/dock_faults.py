"""Which docking mechanisms do not hold: the least that explains the docks that failed.

Two sides that met and do not hold each other accuse both. A side that has held another one is trusted, a boat that is
accused more often than others is blamed before them. Who was blamed wrongly is trusted again when the true cause shows,
because the judgment is made anew from all that was seen.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from swarm_msgs_py.assembly.faces import Face

Side = tuple[int, Face]
"""A boat and one of its sides, in the boat's own frame at the start."""


def broken_sides(failed: Sequence[tuple[Side, Side]], held: Collection[Side]) -> frozenset[Side]:
    """Return the sides to blame for docks that failed: at least one of each.

    Parameters
    ----------
    failed : sequence of (Side, Side)
        Pairs that met and did not hold.
    held : collection of Side
        Sides that have held another one.
    """
    trusted_boats = {boat for boat, _ in held}
    # Two sides that both held once, and not each other now: one of them has failed since.
    accused = [tuple(side for side in pair if side not in held) or pair for pair in failed]
    broken: set[Side] = set()
    while accused:
        boats = {boat for sides in accused for boat, _ in sides}
        counts = {boat: sum(any(one == boat for one, _ in sides) for sides in accused) for boat in boats}
        blamed = max(boats, key=lambda boat: (counts[boat], boat not in trusted_boats, boat))
        broken |= {side for sides in accused for side in sides if side[0] == blamed}
        accused = [sides for sides in accused if all(boat != blamed for boat, _ in sides)]
    return frozenset(broken)
