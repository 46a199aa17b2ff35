"""No routing loop in any interleaving of adverts, losses, delays, repetitions, breaks, joins and departures."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from oracles import find_cycle

from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.dsdv import RouteTable
from swarm_msgs_py.networking.labels import Advert, advert_of
from swarm_msgs_py.types import NodeId

MOST = 6
CONFIG = NetworkConfig(full_dump_period_s=2.0, stale_time_s=8.0, rows_per_hello=4)
picks = st.integers(0, 1000)


class AdvertisingTables(RuleBasedStateMachine):
    """Route tables whose adverts arrive in any order, any number of times, at any time after they were made."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: dict[int, RouteTable] = {}
        self.heard: dict[int, set[int]] = {}  # by node: its current neighbours
        self.on_the_air: list[tuple[int, Advert]] = []
        self.labels: dict[tuple[int, int], int] = {}
        self.numbers: dict[int, int] = {}
        self.tick = 0
        for _ in range(4):
            self.join()

    @precondition(lambda self: len(self.tables) < MOST)
    @rule()
    def join(self) -> None:
        """A node that never lived before; its numbers wrap around soon."""
        node = max(self.tables, default=-1) + 1
        self.tables[node] = RouteTable(NodeId(node), CONFIG, 1.0, sequence=65536 - 2 * node)
        self.heard[node] = set()

    @rule(pick=picks)
    def advertise(self, pick: int) -> None:
        node = self.node(pick)
        self.on_the_air.append((node, advert_of(NodeId(node), self.tables[node].advertise(self.tick))))

    @precondition(lambda self: self.on_the_air)
    @rule(message=picks, receivers=st.sets(st.integers(0, MOST), min_size=1))
    def deliver(self, message: int, receivers: set[int]) -> None:
        """Any advert ever made, old ones too, to anybody."""
        sender, advert = self.on_the_air[-1 - message % len(self.on_the_air)]
        for receiver in sorted(receivers & self.tables.keys() - {sender}):
            self.heard[receiver].add(sender)
            self.tables[receiver].merge(self.tick, [advert])

    @rule(pick=picks)
    def everybody_hears_the_newest(self, pick: int) -> None:
        """Many adverts in one tick, as in a formation."""
        newest = dict(self.on_the_air[-4:])
        receiver = self.node(pick)
        adverts = [advert for sender, advert in sorted(newest.items()) if sender != receiver]
        self.heard[receiver] |= {int(advert.source) for advert in adverts}
        self.tables[receiver].merge(self.tick, adverts)

    @rule(pick=picks, other=picks)
    def break_link(self, pick: int, other: int) -> None:
        node = self.node(pick)
        if self.heard[node]:
            gone = sorted(self.heard[node])[other % len(self.heard[node])]
            self.heard[node].discard(gone)
            self.tables[node].lose(self.tick, [NodeId(gone)])

    @rule(ticks=st.integers(1, 9))
    def wait(self, ticks: int) -> None:
        self.tick += ticks
        for table in self.tables.values():
            table.expire(self.tick)

    @invariant()
    def no_packet_can_run_in_a_circle(self) -> None:
        for destination in self.tables:
            arrows = {
                node: [int(neighbor) for _, neighbor in table.successors(NodeId(destination))]
                for node, table in self.tables.items()
                if node != destination
            }
            assert find_cycle(arrows) == []

    @invariant()
    def next_hops_are_current_neighbors(self) -> None:
        for node, table in self.tables.items():
            for destination in table.reachable:
                route = table.route(destination)
                assert route is not None
                assert route.next_hop in self.heard[node]
                assert route.sequence % 2 == 0
                assert route.next_hop in [neighbor for _, neighbor in table.successors(destination)]

    @invariant()
    def no_hop_count_grows_under_one_number(self) -> None:
        """Counting to infinity would be just that."""
        for node, table in self.tables.items():
            for destination in self.tables:
                route = table.route(NodeId(destination))
                if route is None or route.hops == 255:
                    continue
                known = self.labels.get((node, destination))
                label = route.sequence << 8 | 255 - route.hops
                assert known is None or (label - known) % (1 << 24) < 1 << 23
                self.labels[node, destination] = label

    @invariant()
    def no_node_lowers_its_own_number(self) -> None:
        for node, table in self.tables.items():
            assert (table.sequence - self.numbers.get(node, table.sequence)) % (1 << 16) < 1 << 15
            self.numbers[node] = table.sequence

    def node(self, pick: int) -> int:
        return sorted(self.tables)[pick % len(self.tables)]


AdvertisingTables.TestCase.settings = settings(max_examples=60, stateful_step_count=60, deadline=None)
TestRouteTables = AdvertisingTables.TestCase
