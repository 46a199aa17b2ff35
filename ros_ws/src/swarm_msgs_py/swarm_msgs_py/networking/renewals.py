"""Which route rows a radio says once more where frames are lost: renewed ones that its neighbors seem to have missed.

A renewed row is said in one hello and then only in the next full dump. If that hello is lost on the only way to some
nodes, they wait for the next number, and a second loss in a row makes their routes stale. Repeating every row would
double the cost, most of it for nothing, since in a crowd the same news comes from many radios. So a row is repeated
only where less than `_ENOUGH` neighbors, and not all, have been heard to pass it on: a passive acknowledgement (Jubin
and Tornow 1987) with the counter that keeps broadcasts from becoming a storm (Ni et al., "The broadcast storm problem
in a mobile ad hoc network", MobiCom 1999).
"""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.networking.labels import NUMBER, LabelArray
from swarm_msgs_py.types import IntArray

LOSS_MIN = 0.03
"""Share of lost frames from which on it is worth while; less may be frames that are late."""

_ENOUGH = 3  # neighbors with the news, the one it came from included; there is hardly one left that hears none of them
_ANSWER_TICKS = 2  # in which a neighbor has heard a row and passed it on
_NEVER = -1


class Renewals:
    """What a radio has said of each row, indexed by slot as the columns of its `RouteTable` are."""

    def __init__(self) -> None:
        self._said: LabelArray = np.zeros(0, dtype=np.int32)
        self._again_at: IntArray = np.zeros(0, dtype=np.int64)

    def note(self, tick: int, slots: IntArray, labels: LabelArray) -> None:
        """Note that these rows are said now, each with its label."""
        if missing := max(0, int(slots.max(initial=-1)) + 1 - len(self._said)):
            self._said = np.concatenate((self._said, np.zeros(missing, dtype=np.int32)))
            self._again_at = np.concatenate((self._again_at, np.full(missing, _NEVER)))
        renewed = (labels ^ self._said[slots]) & np.int32(-NUMBER) != 0
        self._said[slots] = labels
        self._again_at[slots[renewed]] = tick + _ANSWER_TICKS

    def missed(self, tick: int, labels: LabelArray, offers: LabelArray, neighbors: int) -> IntArray:
        """Return the slots of the rows to say again now.

        Parameters
        ----------
        tick : int
        labels : (n,) array
            Of the rows.
        offers : (k, n) array
            Best label that each of the neighbors has said of them; rows that stand for no neighbor hold old labels.
        neighbors : int
            How many there are.
        """
        slots = np.flatnonzero(self._again_at == tick)
        if len(slots):
            holders = np.count_nonzero(offers[:, slots] - (labels[slots] & np.int32(-NUMBER)) >= 0, axis=0)
            slots = slots[holders < min(_ENOUGH, neighbors)]
        return slots
