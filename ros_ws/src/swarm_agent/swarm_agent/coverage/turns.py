"""Whose turn it is: which of the robots that wait takes which open place."""

from __future__ import annotations

from collections.abc import Mapping

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import CoverageConfig, Expansion, Rule
from swarm_agent.coverage.frames import Key, Place, State
from swarm_agent.coverage.surroundings import Surroundings
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.types import NodeId


class Turns:
    """One robot's view of those that wait beside it, and of the places that are open.

    Parameters
    ----------
    me : NodeId
    config : CoverageConfig
    """

    def __init__(self, me: NodeId, config: CoverageConfig) -> None:
        self._me, self._config = me, config
        self._open_since: dict[Key, int] = {}

    def place(
        self, tick: int, around: Surroundings, modes: Mapping[NodeId, CoverageMode], board: Board, root: Key
    ) -> Place | None:
        """Return the place for this robot: the k-th of the waiting ones, by descending number, gets the k-th place.

        Parameters
        ----------
        tick : int
        around : Surroundings
        modes : mapping
            What others were doing when last heard.
        board : Board
        root : Key
            The leader's place.
        """
        count = board.count(State.OPEN)
        if not count:
            return None
        expansion = self._config.expansion
        linked = around.ids[around.distances < self._config.range_m].tolist()
        rank = sum(
            r > self._me and modes.get(r) is CoverageMode.WAITING and r not in board.held and r not in board.bound
            for r in linked
        )
        is_serial = expansion is Expansion.SERIAL
        if rank >= count or (is_serial and (rank or board.count(State.TAKEN))):
            return None
        hops = board.hops_from(root, over_taken=expansion is Expansion.PREDICTED)
        is_open = board.places(State.OPEN)
        self._open_since = {place.key: self._open_since.get(place.key, tick) for place in is_open}
        age = 0 if self._config.rule is Rule.LAYOUT or is_serial else self._config.protocol.offer_ticks
        places = [place for place in is_open if place.key in hops and tick - self._open_since[place.key] >= age]
        places.sort(key=lambda place: (hops[place.key], place.key))
        return places[rank] if rank < len(places) else None
