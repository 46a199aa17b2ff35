"""How busy the channel is around each radio: radios that hear each other share one channel, so their rates add up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray, IntArray

WINDOW_S = 1.0
"""Rates are averaged over this time [s]: bit rates are stated per second, and one tick may be much shorter."""

_BITS = 8.0


class ChannelOccupancy:
    """Bits per second on the air in the neighborhood of each radio: what it sends itself and what those it hears send.

    What a radio hears counts whether or not the frame is for it, and whether or not it is lost on the way: the channel
    is taken in any case. The second is the last whole number of ticks that is no shorter than a second.

    Parameters
    ----------
    radios : int
        How many there are.
    period_s : float
        Length of a tick [s].
    """

    def __init__(self, radios: int, period_s: float) -> None:
        ticks = max(1, math.ceil(WINDOW_S / period_s - 1e-9))
        self._window_s = ticks * period_s
        self._heard: FloatArray = np.zeros((ticks, radios))  # bytes; tick k in row k modulo `ticks`

    def note(self, tick: int, sent: IntArray, connected: NDArray[np.bool_]) -> FloatArray:
        """Take in what was on the air in `tick`; ticks must follow each other.

        Parameters
        ----------
        tick : int
        sent : (n,) int array
            Bytes transmitted by each radio in this tick.
        connected : (n, n) bool array
            Who hears whom in this tick, symmetric, False on the diagonal.

        Returns
        -------
        (n,) array
            Rate in each radio's neighborhood over the second that ends with this tick [bit/s].
        """
        self._heard[tick % len(self._heard)] = sent + connected @ sent.astype(np.float64)
        rates: FloatArray = self._heard.sum(axis=0) * (_BITS / self._window_s)
        return rates
