"""How long a packet lives, how it is numbered, and how long a radio remembers it: three times that fit together.

A radio gives a packet up that it has held for too long, and a packet makes a bounded number of hops. So there is an age
beyond which no copy of a packet is on its way any more, and it can be forgotten. Numbers run with the clock: those of
two packets of one node are equal only if the packets are further apart than that, also if the node has lost its memory
in between and numbers afresh.
"""

from __future__ import annotations

import math
from collections.abc import Hashable

from swarm_msgs_py.networking.config import NetworkConfig

_NUMBERS = 1 << 16
_NUMBERS_PER_TICK = 16
_CYCLE_TICKS = _NUMBERS // _NUMBERS_PER_TICK  # after which numbers come again
_MARGIN_TICKS = 256  # of the cycle: so far may a node be ahead of the clock that has sent more packets for a while


def delay_ticks_max(config: NetworkConfig, period_s: float) -> int:
    """Return the longest delay of a frame, beyond the tick it always takes [ticks]."""
    return math.ceil(config.delay_max_s / period_s - 1e-9)


def patience_ticks(config: NetworkConfig, period_s: float) -> int:
    """Return the time after which a routed packet is repeated when no frame is late [ticks]."""
    return max(2, round(config.acknowledge_time_s / period_s))  # out and back takes two ticks


def stay_ticks_max(config: NetworkConfig, period_s: float) -> int:
    """Return how long a radio may hold a packet: through the repair of a route, and then for all its attempts."""
    attempt = patience_ticks(config, period_s) + 2 * delay_ticks_max(config, period_s)
    return round(config.hold_time_s / period_s) + config.attempts * attempt


def lifetime_ticks_max(config: NetworkConfig, period_s: float) -> int:
    """Return the age beyond which no copy of a packet can arrive anywhere.

    Less, if that takes longer than it takes the numbers to come again (radios that hold packets for minutes).
    """
    hop = stay_ticks_max(config, period_s) + 1 + delay_ticks_max(config, period_s)
    return min(config.hop_limit * hop, _CYCLE_TICKS - _MARGIN_TICKS)


class PacketNumbers:
    """Numbers of one node's packets, 16 bits: at least 16 per tick, so that another life of it cannot repeat them.

    A node that sends more than 16 packets in a tick is ahead of the clock for a while.
    """

    def __init__(self) -> None:
        self._next = 0

    def take(self, tick: int) -> int:
        """Return the number of a packet that is made now."""
        number = max(self._next, tick * _NUMBERS_PER_TICK)
        self._next = number + 1
        return number % _NUMBERS


class PacketMemory:
    """The packets that a radio knows, to tell duplicates.

    Parameters
    ----------
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    """

    def __init__(self, config: NetworkConfig, period_s: float) -> None:
        self._capacity = config.seen_packets
        self._ticks = lifetime_ticks_max(config, period_s)
        self._known: dict[Hashable, int] = {}  # and when they came, in order of arrival

    def __len__(self) -> int:
        return len(self._known)

    def expire(self, tick: int) -> None:
        """Forget the packets of which no copy can be on its way any more."""
        known = self._known
        while known and known[oldest := next(iter(known))] < tick - self._ticks:
            del known[oldest]

    def add(self, tick: int, name: Hashable) -> bool:
        """Return whether `name` is new, and remember it; the oldest one is forgotten if there are too many."""
        if name in self._known:
            return False
        self._known[name] = tick
        if len(self._known) > self._capacity:
            del self._known[next(iter(self._known))]
        return True
