"""Who works, what their radios hear and who dies when: the part of a world that is the same whatever the bodies are."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import MISSION, FloatArray, NodeId, node_name
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import Links, LinkTable
from swarm_sim.radio.medium import Medium, RadioTraffic

logger = logging.getLogger(__name__)


class Electronics:
    """Radios, power switches and appointed deaths of all nodes of one run.

    Parameters
    ----------
    radio : RadioConfig
    links : Links
        Who hears whom.
    nodes : sequence of NodeId
        Robots, then `MISSION`; all arrays have this order.
    period_s : float
        Duration of a tick [s].
    seed : int
        Seed of the run.
    deaths : mapping of NodeId to int
        The tick from which on a node is dead, for those that are to die.
    arrivals : mapping of NodeId to int, optional
        The tick from which on a node works, for those that come later; off before, or since its death.

    Attributes
    ----------
    alive : (n,) bool array
        Who works.
    row : dict of NodeId to int
        Place of each node in arrays.
    traffic : RadioTraffic
        What was on the air in this tick.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - all that a run says of its radios
        self,
        radio: RadioConfig,
        links: Links,
        nodes: Sequence[NodeId],
        period_s: float,
        seed: int,
        deaths: Mapping[NodeId, int],
        arrivals: Mapping[NodeId, int] = MappingProxyType({}),
    ) -> None:
        self.row = {node: row for row, node in enumerate(nodes)}
        self.alive: NDArray[np.bool_] = np.ones(len(nodes), dtype=np.bool_)
        self.traffic = RadioTraffic()
        self._links = links
        self._medium = Medium(radio, tuple(nodes), period_s, seed)
        self._inboxes: list[tuple[bytes, ...]] = [()] * len(nodes)
        self._table: LinkTable | None = None
        self._deaths, self._died = dict(deaths), list[NodeId]()
        self._arrivals, self._arrived = dict(arrivals), list[NodeId]()
        for node, tick in self._arrivals.items():
            if self._deaths.get(node, tick) >= tick:
                self.alive[self.row[node]] = False
        self._keep_appointments(0)

    @property
    def inboxes(self) -> Sequence[tuple[bytes, ...]]:
        """What each node's radio has heard since the last tick."""
        return self._inboxes

    def is_alive(self, node: NodeId) -> bool:
        """Return whether a node works; raises `KeyError` if it does not exist."""
        return bool(self.alive[self.row[node]])

    def links(self, antennas: FloatArray) -> LinkTable:
        """Return who hears whom in this tick, with the antennas at (n, d) [m]."""
        if self._table is None:
            self._table = self._links.evaluate(antennas, self.alive)
        return self._table

    def transmit(self, tick: int, outboxes: Mapping[NodeId, tuple[bytes, ...]], antennas: FloatArray) -> None:
        """Put frames on the air, those of dead nodes left out; once per tick.

        Raises
        ------
        KeyError
            If an address does not exist.
        """
        live = {node: frames for node, frames in outboxes.items() if self.is_alive(node)}
        self.traffic = self._medium.transmit(tick, live, self.links(antennas))

    def kill(self, tick: int, node: NodeId) -> bool:
        """Let a node work no more, also if it was to come later; return whether it did until now.

        Raises
        ------
        KeyError
            If it does not exist.
        """
        self._arrivals.pop(node, None)
        return self._switch_off(tick, node)

    def revive(self, tick: int, node: NodeId) -> bool:
        """Let a node work from now on; return whether it did not until now.

        Raises
        ------
        KeyError
            If it does not exist.
        """
        if self.is_alive(node):
            return False
        logger.info("tick %d: %s is switched on", tick, node_name(node))
        self.alive[self.row[node]] = True
        self._table = None
        return True

    def begin(self, tick: int) -> None:
        """Collect what the radios have heard by the beginning of a tick; then let live and die whose time has come.

        So nobody who is dead learns anything in this tick.
        """
        self._inboxes = self._medium.collect(tick, self.alive)
        self.traffic = RadioTraffic()
        self._table = None
        self._keep_appointments(tick)

    def _keep_appointments(self, tick: int) -> None:
        for node in sorted(node for node, appointed in self._deaths.items() if appointed <= tick):
            del self._deaths[node]
            self._switch_off(tick, node)
            self._died.append(node)
        for node in sorted(node for node, appointed in self._arrivals.items() if appointed <= tick):
            del self._arrivals[node]
            self.revive(tick, node)
            self._arrived.append(node)

    def _switch_off(self, tick: int, node: NodeId) -> bool:
        if not self.is_alive(node):
            return False
        logger.info("tick %d: %s died", tick, node_name(node))
        self.alive[self.row[node]] = False
        self._medium.silence(node)
        self._inboxes[self.row[node]] = ()
        self._table = None
        return True

    def take_died(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that died because it was appointed, in the order of their deaths."""
        died, self._died = tuple(self._died), []
        return died

    def take_arrived(self) -> tuple[NodeId, ...]:
        """Return, once, the nodes that were switched on because it was appointed, in that order."""
        arrived, self._arrived = tuple(self._arrived), []
        return arrived


def death_line(node: NodeId) -> str:
    """Return what the operator reads when a node dies because the scenario says so."""
    what = "is switched off" if node == MISSION else "dies"
    return f"{node_name(node)} {what}, as the scenario says"


def arrival_line(node: NodeId) -> str:
    """Return what the operator reads when a robot is switched on because the scenario says so."""
    return f"{node_name(node)} is switched on, as the scenario says"
