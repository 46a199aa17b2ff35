"""How fast a radio may speak, so that all radios that hear each other fit on one channel."""

from __future__ import annotations

import math

from swarm_msgs_py.networking.config import NetworkConfig

_BITS = 8.0
_BURST_S = 0.5  # of unused time is saved up: what comes rarely goes at once
_DEBT_MAX_S = 5.0  # a packet that takes longer than this to pay for blocks what is behind it no longer than this


class Pacer:
    """Token bucket (RFC 2697) filled with one radio's share of the channel.

    A radio divides the channel by the greatest number of radios that share one in its earshot: its own neighborhood or
    a neighbor's. So the shares of a radio and all its neighbors add up to at most the channel, around every radio: each
    of them has divided by no less than the size of that neighborhood. A packet goes when there is any token at all and
    may leave a debt, so a packet of any length gets through.

    Parameters
    ----------
    config : NetworkConfig
    period_s : float
        Length of a tick [s].
    """

    def __init__(self, config: NetworkConfig, period_s: float) -> None:
        self._bytes_per_tick = config.paced_bps / _BITS * period_s
        self._burst_ticks = max(1.0, _BURST_S / period_s)
        self._debt_ticks = max(1.0, _DEBT_MAX_S / period_s)
        self._tokens = 0.0  # bytes
        self._filled_at = -math.inf  # the bucket is full at first

    def fill(self, tick: int, sharers: int) -> None:
        """Add what has accrued since the last call.

        Parameters
        ----------
        tick : int
        sharers : int
            Radios in the most crowded neighborhood that this radio is part of, itself included; at least 1.
        """
        share = self._bytes_per_tick / sharers
        accrued = max(self._tokens, -self._debt_ticks * share) + (tick - self._filled_at) * share
        self._tokens = min(accrued, self._burst_ticks * share)
        self._filled_at = tick

    @property
    def room(self) -> float:
        """Bytes that all radios around one may send together in a tick."""
        return self._bytes_per_tick

    @property
    def is_open(self) -> bool:
        """Whether a packet may go now."""
        return self._tokens > 0.0

    def spend(self, size: int) -> None:
        """Pay for a packet of `size` bytes on the air."""
        self._tokens -= size
