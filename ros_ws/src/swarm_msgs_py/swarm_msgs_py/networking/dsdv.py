"""Destination-sequenced distance-vector routes: the table of one node, as a pure object.

Semantics of Perkins and Bhagwat (SIGCOMM 1994) as spec sections 5.2 and 5.3 fix them: a destination numbers itself with
even numbers; a node that loses its next hop marks the route infinite with the next odd number; newer beats older, and
of equally new offers the shorter one wins. Four choices depart from them:

* *A break concerns those who route through its sender.* An infinite row is believed from the route's own next hop only.
  Others keep their route, which does not lead over the break; nothing is gained by dropping it.
* *Feasible successors.* The latest offer of every neighbour is kept. When the next hop fails, a neighbour that offers a
  route of the same number and no more hops replaces it; only without one is the route broken. (The condition is that
  of DUAL, Garcia-Luna-Aceves 1993, and of Babel, RFC 8966.)
* *Nothing is unlearnt.* A stale row is no longer used or advertised, but its label stays a floor for later offers.
* *A number lasts a dump period*, not one advert (section 5.2): each new number is a row in everybody's next hello, and
  one per tick would fill the channel of a crowd (docs/decisions/0008-numbers-per-dump.md). Instead, where frames are
  lost, renewed rows that neighbors seem to have missed are said twice (`renewals`).

Why there is never a loop
-------------------------
Compare labels (number, hops) of one destination: newer is better, and of one number fewer hops are better. Then:

1. *The label of a node never gets worse.* It changes by adoption of a better offer, to a feasible successor (same
   number, no more hops), or by a break (a newer number). Deletion keeps it. The destination only raises its number.
2. *A next hop has a strictly better label.* When node i takes next hop k, it does so on a label that k once advertised,
   and i's own label is that one plus one hop: worse. By 1, k's label can only have improved since, and i's label
   changes only together with a check against an offer (or by a break, which removes the next hop). So at any instant
   the label improves strictly along each next hop, and a chain of next hops cannot return to where it was. The same
   holds for *every* feasible successor, so a packet may take any of them. As long as no table is lost, adverts may be
   lost, repeated, reordered and delayed at will (short of the 2^14 dumps, half a day, after which numbers wrap).
3. *Damping and incremental adverts* only delay what others hear of a label. By 2, an old label is as safe as a new one.
4. *Joining and leaving.* A node that starts with an empty table has no label, and nobody may point to it. Only here the
   delay needs a bound: `MeshNetwork` keeps a node that may have had an earlier life silent until its neighbors must
   have forgotten it, adverts up to `NetworkConfig.delay_max_s` late included. Beyond that, routes may circle.

Counting to infinity would raise hops at a constant number, which 1 excludes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from swarm_msgs_py.messages.radio import RouteRows
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.labels import (
    LONG_AGO,
    NUMBER,
    Advert,
    BoolArray,
    LabelArray,
    Route,
    broken,
    hops_of,
    is_finite,
    labels_of,
    sequences_of,
    unpacked,
)
from swarm_msgs_py.networking.renewals import LOSS_MIN, Renewals
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

_NOBODY = -1
_NO_INDEX = 0  # index of no neighbour
_UNKNOWN, _SELF = 0, 1  # slots of the table: 0 belongs to no destination, 1 to the node itself
_DELETED, _BROKEN, _ACTIVE = 0, 1, 2
_DUMP_TURNS = 2  # into which the nodes share their full dumps
_COLUMNS = (
    *("_destination", "_label", "_next_hop", "_state", "_refreshed_at"),
    *("_first_at", "_best_at", "_settling", "_pending", "_due_at"),
)


class RouteTable:
    """Routes of one node to every destination that it has heard of.

    Rows live in parallel columns, indexed by *slot*; offers in a matrix, neighbour index by slot.

    Parameters
    ----------
    node : NodeId
        Whose table it is.
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    sequence : int
        The node's own number to begin with, even.
    """

    def __init__(self, node: NodeId, config: NetworkConfig, period_s: float, sequence: int = 0) -> None:
        self._node = node
        self._dump_ticks = max(1, round(config.full_dump_period_s / period_s))
        self._stale_ticks = max(1, round(config.stale_time_s / period_s))
        self._settling_factor = config.settling_factor
        self._settling_max = config.settling_max_s / period_s
        self._rows_per_hello = config.rows_per_hello
        self._slot_of = np.zeros(1 << 16, dtype=np.int64)  # by address; untouched pages cost nothing
        self._neighbor_ids = np.full(16, _NOBODY, dtype=np.int64)  # by neighbour index
        self._index_of = np.zeros(1 << 16, dtype=np.int64)  # by address
        self._slots = 1  # slots in use, the unknown one included
        self._destination: IntArray = np.zeros(0, dtype=np.int64)
        self._label: LabelArray = np.zeros(0, dtype=np.int32)
        self._next_hop: IntArray = np.zeros(0, dtype=np.int64)
        self._state = np.zeros(0, dtype=np.int8)
        self._refreshed_at: IntArray = np.zeros(0, dtype=np.int64)
        self._first_at: IntArray = np.zeros(0, dtype=np.int64)  # when the present number, and its best offer, arrived
        self._best_at: IntArray = np.zeros(0, dtype=np.int64)
        self._settling: FloatArray = np.zeros(0)  # mean time between the two [ticks]
        self._pending: BoolArray = np.zeros(0, dtype=np.bool_)
        self._due_at: IntArray = np.zeros(0, dtype=np.int64)
        self._offers: LabelArray = np.zeros((16, 0), dtype=np.int32)
        self._renewals = Renewals()
        self._reachable: tuple[NodeId, ...] | None = None
        self._reserve(64)
        self._next_hop[_UNKNOWN] = _NOBODY
        self._add(int(node), 0)
        self._label[_SELF] = self._numbered(sequence)
        self._state[_SELF] = _ACTIVE

    # -- reading -------------------------------------------------------------------------------------------------------

    @property
    def sequence(self) -> int:
        """The node's own number."""
        return int(sequences_of(self._label[_SELF : _SELF + 1])[0])

    @property
    def reachable(self) -> tuple[NodeId, ...]:
        """Destinations with a valid route, ascending, without the node itself."""
        if self._reachable is None:
            usable = self._state[: self._slots] == _ACTIVE
            usable[_SELF] = False
            self._reachable = tuple(NodeId(d) for d in np.sort(self._destination[: self._slots][usable]).tolist())
        return self._reachable

    def route(self, destination: NodeId) -> Route | None:
        """Return the row for `destination`, None when there is none."""
        slot = self._slot_of[destination]
        if slot in (_UNKNOWN, _SELF) or self._state[slot] == _DELETED:
            return None
        label = self._label[slot : slot + 1]
        next_hop = NodeId(int(self._next_hop[slot]))
        return Route(destination, next_hop, int(hops_of(label)[0]), int(sequences_of(label)[0]))

    def successors(self, destination: NodeId) -> list[tuple[int, NodeId]]:
        """Return the neighbours that may carry a packet to `destination`, none of which can lead it in a circle.

        Returns
        -------
        list of (hops, NodeId)
            Hops over that neighbour, ascending; of equals the route's next hop is first, then the lower id.
        """
        slot = self._slot_of[destination]
        if slot in (_UNKNOWN, _SELF) or self._state[slot] != _ACTIVE:
            return []
        offers = self._offers[:, slot]
        feasible = np.flatnonzero((offers - self._label[slot : slot + 1] >= 0) & is_finite(offers))
        next_hop = self._next_hop[slot]
        ids, hops = self._neighbor_ids[feasible].tolist(), hops_of(offers[feasible]).tolist()
        ranked = sorted(zip(hops, [neighbor != next_hop for neighbor in ids], ids, strict=True))
        return [(hop_count, NodeId(neighbor)) for hop_count, _, neighbor in ranked]

    def vicinity(self, neighbors: IntArray) -> BoolArray:
        """Return which of the `neighbors` (row) hears which (column) directly, as far as its adverts tell; (k, k)."""
        slots = self._slot_of[neighbors]
        offers = self._offers[self._index_of[neighbors][:, None], slots]
        hears: BoolArray = (slots != _UNKNOWN) & (hops_of(offers) == 2)
        np.fill_diagonal(hears, val=True)
        return hears

    def crowd(self) -> int:
        """Return how many radios share the channel around this node or the one of its neighbors who hears the most."""
        around = np.count_nonzero(hops_of(self._offers[:, : self._slots]) == 2, axis=1)  # by neighbor index
        return 1 + max(int(around.max()), int(np.count_nonzero(self._neighbor_ids != _NOBODY)))

    # -- changing ------------------------------------------------------------------------------------------------------

    def merge(self, tick: int, adverts: Sequence[Advert]) -> None:
        """Take in the adverts of one tick, at most one per neighbour; their sources thereby are neighbours.

        All rows of all adverts are judged together: one vector operation per rule, not one loop turn per row.
        """
        sources, destinations, labels = unpacked(adverts)
        slots = self._slot_of[destinations]
        if not slots.all():
            unknown = slots == _UNKNOWN
            for destination, label in zip(destinations[unknown].tolist(), labels[unknown].tolist(), strict=True):
                if self._slot_of[destination] == _UNKNOWN:
                    self._add(destination, label)
            slots = self._slot_of[destinations]
        indices = self._index_of[sources]
        if not indices.all():
            for source in np.unique(sources[indices == _NO_INDEX]).tolist():
                self._add_neighbor(source)
            indices = self._index_of[sources]
        self._record(indices, slots, labels)
        margins = labels - self._label[slots]  # > 0: a better label
        finite = is_finite(labels)
        better = ((margins > 0) & finite).nonzero()[0]
        if len(better):
            self._adopt(tick, slots[better], labels[better], margins[better], sources[better])
        if not finite.all():
            rows = np.flatnonzero(~finite)
            self._withdraw(tick, slots[rows], labels[rows], sources[rows])

    def lose(self, tick: int, neighbors: Iterable[NodeId]) -> None:
        """Mend or break every route through neighbours that are gone."""
        gone = [neighbor for neighbor in neighbors if self._index_of[neighbor] != _NO_INDEX]
        for neighbor in gone:
            index = self._index_of[neighbor]
            self._index_of[neighbor] = _NO_INDEX
            self._neighbor_ids[index] = _NOBODY
            self._offers[index] = self._nothing()
        if gone:
            slots = np.flatnonzero(np.isin(self._next_hop[: self._slots], gone))
            self._repair(tick, slots, broken(self._label[slots]))

    def expire(self, tick: int) -> None:
        """Delete the rows that were not refreshed within the stale time; their labels stay as floors."""
        count = self._slots
        stale = (self._refreshed_at[:count] <= tick - self._stale_ticks) & (self._state[:count] != _DELETED)
        stale[_SELF] = False
        if stale.any():
            slots = np.flatnonzero(stale)
            self._state[slots] = _DELETED
            self._next_hop[slots] = _NOBODY
            self._pending[slots] = False
            self._reachable = None

    def advertise(self, tick: int, loss: float = 0.0) -> RouteRows:
        """Return the rows for this tick's hello: the own row, and what changed or, once per dump period, everything.

        The node's number rises by two with each full dump. Nodes dump in two turns, by their ids: merging many dumps
        at once costs little more than merging one, and two turns keep the peak of a neighbourhood's load low. Where
        a share `loss` of the frames is lost, renewed rows that neighbors seem to have missed are said twice.
        """
        count, is_lossy = self._slots, loss > LOSS_MIN
        if is_lossy:
            neighbors = int(np.count_nonzero(self._neighbor_ids != _NOBODY))
            missed = self._renewals.missed(tick, self._label, self._offers, neighbors)
            self._announce(tick, missed[self._state[missed] != _DELETED])
        if (tick - self._node % _DUMP_TURNS * self._dump_ticks // _DUMP_TURNS) % self._dump_ticks == 0:
            self._label[_SELF] = self._numbered(self.sequence + 2)
            self._challenge_neighbors(tick)
            self._forget_old_offers()
            known = (self._state[:count] != _DELETED) & ~self._pending[:count]
            self._pending[:count] |= known
            self._due_at[:count][known] = tick
        self._pending[_SELF] = False
        due = (self._pending[:count] & (self._due_at[:count] <= tick)).nonzero()[0]
        if len(due) >= self._rows_per_hello:  # breaks are never the ones that wait
            order = np.lexsort((self._destination[due], self._due_at[due], self._state[due] == _ACTIVE))
            due = due[order[: self._rows_per_hello - 1]]
        self._pending[due] = False
        if is_lossy:
            self._renewals.note(tick, due, self._label[due])
        slots = np.concatenate(([_SELF], due))
        labels = self._label[slots]
        return RouteRows(self._destination[slots], hops_of(labels), sequences_of(labels))

    def repeat(self, tick: int, destination: NodeId) -> None:
        """Advertise the row of `destination` again: somebody has not understood that it is broken."""
        slot = self._slot_of[destination]
        if self._state[slot] == _BROKEN:
            self._announce(tick, slot)

    # -- rules ---------------------------------------------------------------------------------------------------------

    def _announce(self, tick: int, slots: IntArray) -> None:
        self._pending[slots] = True
        self._due_at[slots] = tick

    def _record(self, indices: IntArray, slots: IntArray, labels: LabelArray) -> None:
        """Keep the best label that each neighbour has ever advertised (labels never get worse)."""
        cells = indices * self._offers.shape[1] + slots
        offers = self._offers.reshape(-1)
        newer = labels - offers[cells] > 0
        offers[cells[newer]] = labels[newer]

    def _outnumber(self, heard: LabelArray) -> None:
        """Take a number above those that others hold for this node, unless its own is above them already.

        Odd: somebody lost the route to this node. Even: they remember an earlier life of it.
        """
        own = self._label[_SELF : _SELF + 1]
        newest = int(sequences_of(heard[np.argmax(heard - own)][None])[0])
        above = labels_of(np.array([newest + 2 - newest % 2]) & 0xFFFF, np.zeros(1, dtype=np.int64))
        if above - own > 0:  # else what was heard is older, or too far off to tell
            self._label[_SELF] = above[0]

    def _adopt(self, tick: int, slots: IntArray, labels: LabelArray, margins: LabelArray, via: IntArray) -> None:
        """Take the best of the better offers for each slot; of equals the one of the lowest neighbour."""
        if (slots == _SELF).any():
            others = slots != _SELF
            self._outnumber(labels[~others])
            slots, labels, margins, via = slots[others], labels[others], margins[others], via[others]
        order = np.lexsort((via, -margins, slots))
        slots = slots[order]
        first = np.ones(len(slots), dtype=np.bool_)
        np.not_equal(slots[1:], slots[:-1], out=first[1:])
        chosen = order[first]
        slots, labels, via = slots[first], labels[chosen], via[chosen]
        old, was_active = self._label[slots], self._state[slots] == _ACTIVE
        renumbered = (labels ^ old) & np.int32(-NUMBER) != 0
        new = slots[renumbered]
        sample = self._best_at[new] - self._first_at[new]
        self._settling[new] += 0.25 * (sample - self._settling[new])
        self._first_at[new] = tick
        self._refreshed_at[new] = tick
        self._best_at[slots] = tick
        waits = np.minimum(np.ceil(self._settling_factor * self._settling[slots]), self._settling_max)
        worse = was_active & ((labels & 0xFF00) < (old & 0xFF00))
        self._label[slots] = labels
        self._next_hop[slots] = via
        self._state[slots] = _ACTIVE
        self._pending[slots] = True
        self._due_at[slots] = tick + np.where(worse, waits, 0.0).astype(np.int64)
        if not was_active.all():
            self._reachable = None

    def _withdraw(self, tick: int, slots: IntArray, labels: LabelArray, via: IntArray) -> None:
        """Judge infinite rows: obey the next hop, answer those who could use this node's route, just adopted or not."""
        rumors = labels[slots == _SELF]
        if len(rumors):
            self._outnumber(rumors)
        active = (self._state[slots] == _ACTIVE) & (slots != _SELF)
        answer = slots[active & (self._label[slots] - labels >= 0)]
        self._announce(tick, answer)
        obeyed = active & (labels - self._label[slots] > 0) & (self._next_hop[slots] == via)
        if obeyed.any():
            self._repair(tick, slots[obeyed], labels[obeyed])

    def _repair(self, tick: int, slots: IntArray, otherwise: LabelArray) -> None:
        """Replace the next hops of `slots` by feasible successors, or break the route with the label `otherwise`."""
        if not len(slots):
            return
        margins = np.where(is_finite(self._offers[:, slots]), self._offers[:, slots] - self._label[slots], np.int32(-1))
        best = margins.max(axis=0)
        found = best >= 0
        ids = np.where(margins == best, self._neighbor_ids[:, None], 1 << 16).min(axis=0)
        self._next_hop[slots] = np.where(found, ids, _NOBODY)
        improved = slots[found & (best > 0)]
        self._label[slots[found]] += best[found]
        cut = slots[~found]
        self._label[cut] = otherwise[~found]
        self._state[cut] = _BROKEN
        self._refreshed_at[cut] = tick
        self._announce(tick, np.concatenate((improved, cut)))
        self._reachable = None

    def _challenge_neighbors(self, tick: int) -> None:
        """Tell a neighbour that numbers itself too low (it has restarted) the number that it has to exceed."""
        slots = self._slot_of[self._neighbor_ids[self._neighbor_ids != _NOBODY]]
        slots = slots[(slots != _UNKNOWN) & (self._state[slots] != _ACTIVE)]
        self._label[slots] = broken(self._label[slots])
        self._state[slots] = _BROKEN
        self._refreshed_at[slots] = tick

    def _forget_old_offers(self) -> None:
        """Drop offers so old that their numbers will soon look new again."""
        self._offers = np.where(self._label - self._offers > LONG_AGO, self._nothing(), self._offers)

    # -- storage -------------------------------------------------------------------------------------------------------

    def _numbered(self, sequence: int) -> np.int32:
        return np.int32(labels_of(np.array(sequence & 0xFFFF), np.array(0)))

    def _nothing(self) -> LabelArray:
        """Return, for each slot, the label of a neighbour that has not offered anything yet."""
        return (self._label & np.int32(-NUMBER)) - np.int32(LONG_AGO)

    def _add_neighbor(self, neighbor: int) -> None:
        """Give `neighbor` a row in the matrix of offers."""
        free = np.flatnonzero(self._neighbor_ids == _NOBODY)
        if len(free) == 1:  # index 0 belongs to nobody
            self._neighbor_ids = np.concatenate((self._neighbor_ids, np.full_like(self._neighbor_ids, _NOBODY)))
            self._offers = np.concatenate((self._offers, np.tile(self._nothing(), (len(self._offers), 1))))
            free = np.flatnonzero(self._neighbor_ids == _NOBODY)
        self._neighbor_ids[free[1]] = neighbor
        self._index_of[neighbor] = free[1]

    def _add(self, destination: int, label: int) -> None:
        """Give `destination` a slot; its label is just worse than `label`, which is about to be judged."""
        if self._slots == len(self._label):
            self._reserve(2 * self._slots)
        slot = self._slots
        self._slots += 1
        self._slot_of[destination] = slot
        self._destination[slot] = destination
        self._next_hop[slot] = _NOBODY
        self._label[slot : slot + 1] = (np.array([label], dtype=np.int32) & np.int32(-NUMBER)) - np.int32(NUMBER)
        self._offers[:, slot] = self._nothing()[slot]

    def _reserve(self, slots: int) -> None:
        """Make room for `slots` rows in every column."""
        grown = slots - len(self._label)
        for name in _COLUMNS:
            column = getattr(self, name)
            setattr(self, name, np.concatenate((column, np.zeros(grown, dtype=column.dtype))))
        self._offers = np.hstack((self._offers, np.zeros((len(self._offers), grown), dtype=np.int32)))
