"""What a radio transmits first when there is more to say than the channel has room for, and when it repeats itself."""

from __future__ import annotations

from builders import make_presence

from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.radio import Acknowledgement, Packet
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.lifetimes import stay_ticks_max
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.networking.outbox import Outbox
from swarm_msgs_py.networking.pacer import Pacer
from swarm_msgs_py.types import EVERYONE, NodeId

PERIOD_S = 0.5
ME, NEAR, FAR = NodeId(1), NodeId(2), NodeId(9)


def make_pacer() -> Pacer:
    pacer = Pacer(NetworkConfig(paced_bps=1e9), PERIOD_S)
    pacer.fill(0, 1)
    return pacer


def attempts(outbox: Outbox, ticks: range, delay: int = 0) -> list[int]:
    """Return the ticks in which something is transmitted to `NEAR`, which never acknowledges."""
    return [tick for tick in ticks if outbox.due(tick, lambda _: [NEAR], make_pacer(), delay=delay)]


def make_packet(destination: NodeId, number: int = 1) -> Packet:
    return Packet(ME, 0, EVERYONE, ME, destination, number, 9, b"")


def test_a_packet_is_repeated_after_the_time_that_its_acknowledgement_takes() -> None:
    prompt, late = Outbox(NetworkConfig(), PERIOD_S), Outbox(NetworkConfig(), PERIOD_S)
    for outbox in (prompt, late):
        outbox.put(0, make_packet(NEAR))

    assert attempts(prompt, range(8)) == [0, 2, 4, 6]
    assert attempts(late, range(8), delay=1) == [0, 4]


def test_only_packets_to_the_wanted_destinations_are_taken() -> None:
    outbox = Outbox(NetworkConfig(), PERIOD_S)
    outbox.put(0, make_packet(FAR, 1))
    outbox.put(0, make_packet(NEAR, 2))

    near = outbox.due(0, lambda _: [NEAR], make_pacer(), destinations={NEAR})
    rest = outbox.due(0, lambda _: [NEAR], make_pacer())

    assert [packet.number for packet, _ in near] == [2]
    assert [packet.number for packet, _ in rest] == [1]


class Trio:
    """A radio with a neighbor, and another node behind that; the radio is paced so that one packet goes per tick."""

    def __init__(self, lateness: int = 0) -> None:
        config = NetworkConfig(paced_bps=1000.0)
        self.radios = {node: MeshNetwork(node, config, PERIOD_S) for node in (ME, NEAR, FAR)}
        self.links = [(ME, NEAR), (NEAR, FAR)]
        self.tick = 0
        self._lateness = lateness
        self._air: list[tuple[int, NodeId, tuple[bytes, ...]]] = []  # when it arrives, from whom, what

    def hear(self) -> None:
        for node, radio in self.radios.items():
            sources = {a if b == node else b for a, b in self.links if node in (a, b)}
            inbox = [f for at, source, frames in self._air if at == self.tick and source in sources for f in frames]
            radio.receive(self.tick, inbox)

    def say(self) -> list[Packet]:
        """End the tick, and return the packets that `ME` transmitted."""
        said = {node: radio.transmit(self.tick, make_presence(tick=self.tick)) for node, radio in self.radios.items()}
        self.tick += 1
        self._air += [(self.tick + self._lateness, node, frames) for node, frames in said.items()]
        return [frame for frame in map(decode_frame, said[ME]) if isinstance(frame, Packet)]

    def run(self, ticks: int) -> None:
        for _ in range(ticks):
            self.hear()
            self.say()


def test_own_floods_go_first_then_what_neighbors_ask_then_relays_then_what_goes_far() -> None:
    trio = Trio()
    trio.run(20)
    me = trio.radios[ME]
    relayed = Packet(NEAR, 0, EVERYONE, NodeId(50), EVERYONE, 1, 5, bytes(400))
    trio.links.append((ME, NodeId(60)))  # somebody whom only this radio can serve
    trio.radios[NodeId(60)] = MeshNetwork(NodeId(60), NetworkConfig(), PERIOD_S)
    trio.run(20)

    trio.hear()
    me.receive(trio.tick, [encode_frame(relayed)])
    me.send(FAR, bytes(400))
    me.send(NEAR, bytes(400))
    me.flood(bytes(400))
    order: list[NodeId] = []
    for _ in range(60):
        order += [packet.origin if packet.destination == EVERYONE else packet.destination for packet in trio.say()]
        trio.hear()

    assert list(dict.fromkeys(order)) == [ME, NEAR, NodeId(50), FAR]


def test_a_radio_learns_from_hellos_how_long_to_wait_for_acknowledgements() -> None:
    """Every frame takes one tick more than usual: an acknowledgement is back four ticks after its packet."""
    repeated = {}
    for lateness in (0, 1):
        trio = Trio(lateness)
        trio.run(30)
        trio.hear()
        trio.radios[ME].send(NEAR, b"x")
        sent = []
        for _ in range(12):
            sent += trio.say()
            trio.hear()
        repeated[lateness] = len(sent) - 1

    assert repeated == {0: 0, 1: 0}
    assert NetworkConfig().delay_max_s >= PERIOD_S  # so long a delay is provided for


def test_only_a_radio_that_was_asked_can_acknowledge() -> None:
    outbox = Outbox(NetworkConfig(), PERIOD_S)
    outbox.put(0, make_packet(FAR))
    outbox.due(0, lambda _: [NEAR], make_pacer())

    outbox.acknowledge(ME, Acknowledgement(NodeId(3), 1, ((ME, ME, 1),)))
    assert len(outbox) == 1
    outbox.acknowledge(ME, Acknowledgement(NEAR, 1, ((ME, ME, 1),)))
    assert len(outbox) == 0


def test_a_packet_that_never_gets_a_turn_is_dropped_at_the_age_that_all_its_attempts_could_take() -> None:
    config = NetworkConfig()
    outbox, broke = Outbox(config, PERIOD_S), Pacer(config, PERIOD_S)
    outbox.put(0, make_packet(FAR))
    stay = stay_ticks_max(config, PERIOD_S)

    assert outbox.due(stay, lambda _: [NEAR], broke) == []
    assert (len(outbox), outbox.dropped) == (1, 0)
    assert outbox.due(stay + 1, lambda _: [NEAR], make_pacer()) == []
    assert (len(outbox), outbox.dropped) == (0, 1)
