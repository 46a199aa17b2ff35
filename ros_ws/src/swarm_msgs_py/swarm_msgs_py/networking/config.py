"""Settings of a node's mesh network."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, setting


class NetworkModel(Enum):
    """How packets get from node to node."""

    MESH = "mesh"
    """Over several hops, by flooding and DSDV routes."""
    IDEAL = "ideal"
    """At once, to everybody: only for radios that all hear each other and lose nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NetworkConfig(Config):
    """Timing and bounds of neighbour discovery, DSDV routing and packet delivery (spec section 5.3)."""

    model: NetworkModel = setting(
        NetworkModel.MESH,
        "mesh: over several hops; ideal: everybody hears everybody, as sim.radio.model ideal sets it for a run",
    )
    full_dump_period_s: float = setting(
        3.0,
        "time between advertisements of the whole route table (spec 5.3, rule 2)",
        unit="s",
        above=0.0,
        maximum=60.0,
    )
    missed_adverts: int = setting(
        3, "a neighbour is gone after this many ticks without a hello (spec 5.3, rule 2)", minimum=1, maximum=100
    )
    stale_time_s: float = setting(
        6.0, "a route not refreshed for this long is deleted (spec 5.3, rule 2)", unit="s", above=0.0, maximum=600.0
    )
    delay_max_s: float = setting(
        1.0,
        "longest delay of a hello, beyond the tick it always takes: a node that starts late keeps silent for as long; "
        "a run raises it to what its radio can do (sim.radio)",
        unit="s",
        minimum=0.0,
        maximum=60.0,
    )
    hop_limit: int = setting(32, "hops that a packet or route may take", unit="hops", minimum=1, maximum=250)
    settling_factor: float = setting(
        2.0,
        "advertise a mere change of cost after this many average settling times (Perkins and Bhagwat 1994; 0: at once)",
        minimum=0.0,
        maximum=10.0,
    )
    settling_max_s: float = setting(1.0, "longest wait of a damped advertisement", unit="s", minimum=0.0, maximum=60.0)
    rows_per_hello: int = setting(
        1000, "route rows in one hello; what is left over follows in the next", unit="rows", minimum=1, maximum=10000
    )
    attempts: int = setting(6, "transmissions of a routed packet per hop before it is dropped", minimum=1, maximum=100)
    acknowledge_time_s: float = setting(
        1.0, "repeat a routed packet that is not acknowledged within this time", unit="s", above=0.0, maximum=60.0
    )
    hold_time_s: float = setting(
        8.0,
        "how long a packet waits for a route to be repaired before it is dropped",
        unit="s",
        minimum=0.0,
        maximum=600.0,
    )
    flood_redundancy: int = setting(
        1,
        "how often more than once every radio shall hear a flooded packet where no frame is lost; more where some are",
        minimum=0,
        maximum=100,
    )
    paced_bps: float = setting(
        90_000.0,
        "rate that packets may take on the channel around any radio; hellos and acknowledgements come on top",
        unit="bit/s",
        minimum=1000.0,
        maximum=1e12,
    )
    seen_packets: int = setting(
        4096, "packets remembered to tell duplicates, the oldest forgotten first", minimum=16, maximum=1000000
    )
    queue_packets: int = setting(
        256, "packets that wait for transmission, the oldest dropped first", minimum=1, maximum=100000
    )
