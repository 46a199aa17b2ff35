"""What travels on the air between two radios, and what the mesh delivers.

A *frame* is one transmission, heard by every radio in range. A *packet* is carried by frames, hop by hop, from its
origin to its destination (or to everyone). A packet's *body* is one of the application records of `bodies`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from swarm_msgs_py.types import FloatArray, IntArray, NodeId

SIGMA_UNKNOWN = 65.535
"""Standard deviation [m] of a radio that does not know where it is; the largest that fits a hello."""


@dataclass(frozen=True, slots=True, eq=False)
class Presence:
    """What a radio says of itself in each of its hello frames.

    Attributes
    ----------
    position, velocity : (2,) array
        Own estimate, world frame [m], [m/s].
    covariance : (2, 2) array
        Of the position [m^2]; `SIGMA_UNKNOWN` on both axes if the radio does not know where it is.
    shared : float
        Share of that variance which the sender supposes its neighbors' estimates to have in common, 0 to 1.
    tick : int
        When all this was true; on the air modulo 2^16.
    robot_type : int
        Type number of the robot, 0 for the mission computer.
    is_beacon : bool
        Carries a position sensor, so others may range to it.
    mode : int
        Value of the robot's mode.
    epoch : int
        Newest plan held, 0 for none.
    digest : int
        Fingerprint of the cost rows held for that plan; equal digests mean equal decisions.
    asks_for_way : bool
        Is on its way somewhere and hardly gets on: neighbors with time to spare may step aside.
    belief : (8,) array
        Position, velocity, covariance (xx, xy, yy) and shared share in one row, so that fifty neighbors stack at once.
    sigma : float
        Standard deviation of the position estimate, root mean square of both axes [m].
    """

    position: FloatArray
    velocity: FloatArray
    covariance: FloatArray
    shared: float
    tick: int
    robot_type: int
    is_beacon: bool
    mode: int
    epoch: int
    digest: int
    asks_for_way: bool = False
    belief: FloatArray = field(init=False, repr=False)
    sigma: float = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Lay out the row, and compute what many ask for."""
        (xx, xy), (_, yy) = self.covariance.tolist()
        belief = np.array([*self.position.tolist(), *self.velocity.tolist(), xx, xy, yy, self.shared])
        belief.flags.writeable = False
        object.__setattr__(self, "belief", belief)
        object.__setattr__(self, "sigma", math.sqrt(max(xx + yy, 0.0) / 2.0))  # of damage too, which frames refuse


@dataclass(frozen=True, slots=True)
class RouteRows:
    """Rows of a DSDV table as advertised, one entry per destination, columns in parallel.

    Attributes
    ----------
    destinations, hops, sequences : (n,) int array
        Address, hop count (`HOPS_INFINITE` for a broken route), destination sequence number.
    """

    destinations: IntArray
    hops: IntArray
    sequences: IntArray


NO_ROUTES = RouteRows(*(np.zeros(0, dtype=np.int64) for _ in range(3)))
"""Rows of a hello that advertises nothing."""

HOPS_INFINITE = 255
"""Hop count that means: no route (one byte on the air)."""


@dataclass(frozen=True, slots=True)
class Hello:
    """One-hop frame: neighbour discovery, presence and route rows in one.

    Attributes
    ----------
    source : NodeId
        The radio that transmits.
    sequence : int
        Frame counter of that radio, modulo 2^16.
    presence : Presence
        Who and where it is.
    routes : RouteRows
        Changed rows, or the whole table in a full dump; never empty of the sender's own row in a full dump.
    """

    source: NodeId
    sequence: int
    presence: Presence
    routes: RouteRows


@dataclass(frozen=True, slots=True)
class Packet:
    """One hop of a multi-hop packet.

    Attributes
    ----------
    source, sequence
        Radio that transmits this hop, and its frame counter.
    next_hop : NodeId
        Who is to take it on; `EVERYONE` in a flood.
    origin, destination : NodeId
        End points; destination `EVERYONE` in a flood.
    number : int
        Packet counter of the origin, modulo 2^16; (origin, number) names the packet in duplicate suppression.
    hops_left : int
        Hops that the packet may still travel.
    body : bytes
        Encoded application record.
    """

    source: NodeId
    sequence: int
    next_hop: NodeId
    origin: NodeId
    destination: NodeId
    number: int
    hops_left: int
    body: bytes


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """One-hop frame: "these routed packets arrived here", the end of their retransmission.

    Attributes
    ----------
    source, sequence
        Radio that transmits, and its frame counter.
    packets : tuple of (NodeId, NodeId, int)
        Radio that transmitted the packet, the packet's origin and its number.
    """

    source: NodeId
    sequence: int
    packets: tuple[tuple[NodeId, NodeId, int], ...]


Frame = Hello | Packet | Acknowledgement


@dataclass(frozen=True, slots=True)
class Delivery:
    """A packet's body, handed to the application at its destination."""

    origin: NodeId
    body: bytes


@dataclass(frozen=True, slots=True)
class RadioCounters:
    """Totals of one radio since the start.

    Attributes
    ----------
    frames_sent, bytes_sent, frames_heard, bytes_heard : int
        Traffic as the radio sees it.
    corrupt, duplicates, expired, unroutable : int
        Dropped: not a frame; seen before; no hops left; no route.
    """

    frames_sent: int = 0
    bytes_sent: int = 0
    frames_heard: int = 0
    bytes_heard: int = 0
    corrupt: int = 0
    duplicates: int = 0
    expired: int = 0
    unroutable: int = 0
