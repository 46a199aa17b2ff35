"""The radio medium: frames in, frames out, with loss, delay and a byte budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import IntArray, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import LinkTable

BITS = 8.0


@dataclass(frozen=True, slots=True)
class RadioTraffic:
    """What was on the air in one tick.

    Attributes
    ----------
    frames, bytes : int
        Transmitted by all radios together.
    peak_bps : float
        Largest rate of any one radio [bit/s].
    dropped : int
        Frames that a radio could not transmit, its budget being spent.
    """

    frames: int = 0
    bytes: int = 0
    peak_bps: float = 0.0
    dropped: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Flight:
    """Frames of one tick that arrive together.

    Attributes
    ----------
    frames : sequence of bytes
    senders : (f,) int array
        Row of the sender, ascending.
    heard : (f, n) bool array
        Which receiver gets which frame.
    """

    frames: Sequence[bytes]
    senders: IntArray
    heard: NDArray[np.bool_]


class Medium:
    """Carries frames between radios; one tick is `transmit`, then `collect` in the next tick.

    Parameters
    ----------
    config : RadioConfig
    radios : sequence of NodeId
        All addresses, ascending.
    period_s : float
        Length of a tick [s].
    seed : int
        Seed of the run.
    """

    def __init__(self, config: RadioConfig, radios: Sequence[NodeId], period_s: float, seed: int) -> None:
        self._config = config
        self._radios = tuple(radios)
        self._period_s = period_s
        self._allowance = config.budget_bps / BITS * period_s
        self._tokens = [self._allowance] * len(radios)
        # A stream per sender: what one radio sends never changes the luck of another.
        self._rngs = [rng_for(seed, "radio", radio) for radio in radios]
        self._flights: dict[int, list[_Flight]] = {}

    def transmit(self, tick: int, outboxes: Mapping[NodeId, Sequence[bytes]], links: LinkTable) -> RadioTraffic:
        """Put the frames of a tick on the air.

        Parameters
        ----------
        tick : int
        outboxes : mapping of NodeId to sequence of bytes
            Frames in the order of transmission; dead radios must not be among the senders.
        links : LinkTable
            Links now, in the order of `radios`.
        """
        frames: list[bytes] = []
        senders: list[int] = []
        misses = []
        sent_bytes, peak, dropped = 0, 0, 0
        for row, radio in enumerate(self._radios):
            outbox = outboxes.get(radio, ())
            accepted = self._spend(row, outbox)
            size = sum(map(len, accepted))
            sent_bytes, peak, dropped = sent_bytes + size, max(peak, size), dropped + len(outbox) - len(accepted)
            frames += accepted
            senders += [row] * len(accepted)
            if self._is_random and accepted:
                misses.append(self._rngs[row].random((len(accepted), 2, len(self._radios))))
        if frames:
            self._launch(tick, frames, np.array(senders), np.concatenate(misses) if misses else None, links)
        return RadioTraffic(len(frames), sent_bytes, peak * BITS / self._period_s, dropped)

    def collect(self, tick: int, alive: NDArray[np.bool_]) -> list[tuple[bytes, ...]]:
        """Return what each radio heard since the last tick, by sender's address, then by order of transmission.

        Parameters
        ----------
        tick : int
            The tick that begins; each tick's frames can be collected once.
        alive : (n,) bool array
            Radios that are on; the others hear nothing.
        """
        flights = self._flights.pop(tick, [])
        if not flights:
            return [()] * len(self._radios)
        frames = [frame for flight in flights for frame in flight.frames]
        # Older flights stand first and the sort is stable, so each sender's frames stay in order of transmission.
        order = np.argsort(np.concatenate([flight.senders for flight in flights]), kind="stable")
        heard = np.concatenate([flight.heard for flight in flights])[order] & alive
        frames = [frames[index] for index in order.tolist()]
        receivers, arrived = np.nonzero(heard.T)
        cuts = np.searchsorted(receivers, np.arange(len(self._radios) + 1)).tolist()
        arrived_frames = [frames[index] for index in arrived.tolist()]
        return [tuple(arrived_frames[a:b]) for a, b in pairwise(cuts)]

    @property
    def _is_random(self) -> bool:
        return self._config.loss > 0.0 or self._config.delay_ticks_max > 0

    def _spend(self, row: int, outbox: Sequence[bytes]) -> list[bytes]:
        """Return the frames that the radio's budget allows in this tick, in order.

        An idle radio may begin one frame that is longer than a tick's allowance; it then stays busy until the frame is
        paid for.
        """
        tokens = self._tokens[row]
        accepted = []
        for frame in outbox:
            if len(frame) <= tokens or tokens >= self._allowance:
                accepted.append(frame)
                tokens -= len(frame)
        self._tokens[row] = min(tokens + self._allowance, self._allowance)
        return accepted

    def _launch(
        self, tick: int, frames: list[bytes], senders: IntArray, luck: NDArray[np.float64] | None, links: LinkTable
    ) -> None:
        """Decide who hears each frame when, from `luck` (f, 2, n) in [0, 1): one number for loss, one for delay."""
        heard = links.connected[senders]
        if luck is None:
            self._flights.setdefault(tick + 1, []).append(_Flight(frames, senders, heard))
            return
        heard = heard & (luck[:, 0] >= self._config.loss)
        delays = (luck[:, 1] * (self._config.delay_ticks_max + 1)).astype(np.int64)
        for delay in range(self._config.delay_ticks_max + 1):
            arriving = heard & (delays == delay)
            if arriving.any():
                self._flights.setdefault(tick + 1 + delay, []).append(_Flight(frames, senders, arriving))
