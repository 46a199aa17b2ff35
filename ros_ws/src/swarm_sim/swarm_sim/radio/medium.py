"""The radio medium: frames in, frames out, with loss, delay and a bit rate.

A radio transmits its frames one after another at its bit rate. What a tick has no time for goes on in the next: the
rest of a frame that has begun, then the frames that wait behind it. So a frame of any length gets through, in as many
ticks as it takes; who hears it is decided in the tick in which it is complete.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import IntArray, NodeId
from swarm_sim.config import RadioConfig
from swarm_sim.radio.links import LinkTable
from swarm_sim.radio.occupancy import ChannelOccupancy

BITS = 8.0


def longest_delay(config: RadioConfig, period_s: float, size: int) -> int:
    """Return how many ticks a frame can arrive later than in the next tick.

    At worst as much waits before it as `RadioConfig.queue_s` allows, its own transmission takes time, and then it is as
    late as any.

    Parameters
    ----------
    config : RadioConfig
    period_s : float
        Length of a tick [s].
    size : int
        Of the frame [bytes]. One that is not the first of its tick waits for those before it, too: add them.
    """
    bytes_per_tick = config.budget_bps / BITS * period_s
    waiting = config.budget_bps / BITS * config.queue_s
    # One byte more for the fraction that a tick may leave to a later one.
    return config.delay_ticks_max + math.ceil((waiting + size + 1) / bytes_per_tick)


@dataclass(frozen=True, slots=True)
class RadioTraffic:
    """What was on the air in one tick.

    Attributes
    ----------
    frames : int
        Completed by all radios together.
    bytes : int
        Transmitted by all radios together, parts of frames included.
    peak_bps : float
        Largest rate of any one radio [bit/s].
    neighborhood_bps : float
        Largest rate of a radio and all that it hears together, over the second that ends with this tick [bit/s].
    dropped : int
        Frames that no radio will transmit: too much was waiting before them, or the radio went silent.
    """

    frames: int = 0
    bytes: int = 0
    peak_bps: float = 0.0
    neighborhood_bps: float = 0.0
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


class _Transmitter:
    """One radio's frames on their way out: first in, first out, at a constant bit rate."""

    def __init__(self) -> None:
        self._waiting: deque[bytes] = deque()
        self._backlog = 0  # bytes still to transmit
        self._begun = 0  # bytes of the first waiting frame that are on the air already

    def send(self, outbox: Sequence[bytes], allowance: int, backlog_max: float) -> tuple[Sequence[bytes], int, int]:
        """Transmit for one tick.

        Parameters
        ----------
        outbox : sequence of bytes
            New frames.
        allowance : int
            Bytes that the tick has time for.
        backlog_max : float
            A new frame is dropped when more bytes than this would be left before it at the end of the tick.

        Returns
        -------
        frames : sequence of bytes
            Completed in this tick.
        sent : int
            Bytes transmitted in this tick.
        dropped : int
            New frames that were dropped.
        """
        size = sum(map(len, outbox))
        if not self._backlog and size <= allowance:  # nearly always
            return outbox, size, 0
        dropped = 0
        for frame in outbox:
            if self._backlog - allowance > backlog_max:
                dropped += 1
            else:
                self._waiting.append(frame)
                self._backlog += len(frame)
        sent = min(allowance, self._backlog)
        self._backlog -= sent
        self._begun += sent
        done = []
        while self._waiting and self._begun >= len(self._waiting[0]):
            done.append(self._waiting.popleft())
            self._begun -= len(done[-1])
        return done, sent, dropped

    def clear(self) -> int:
        """Forget what waits and return how many frames that were."""
        forgotten = len(self._waiting)
        self._waiting.clear()
        self._backlog = self._begun = 0
        return forgotten


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
        self._bytes_per_tick = config.budget_bps / BITS * period_s
        self._backlog_max = config.budget_bps / BITS * config.queue_s
        self._transmitters = [_Transmitter() for _ in radios]
        self._occupancy = ChannelOccupancy(len(self._radios), period_s)
        self._silenced = 0  # frames lost with their radio since the last tick
        # A stream per sender: what one radio sends never changes the luck of another.
        self._rngs = [rng_for(seed, "radio", radio) for radio in radios]
        self._flights: dict[int, list[_Flight]] = {}

    def transmit(self, tick: int, outboxes: Mapping[NodeId, Sequence[bytes]], links: LinkTable) -> RadioTraffic:
        """Let every radio transmit for one tick, what waits from earlier ticks first; call it in every tick.

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
        sent = np.zeros(len(self._radios), dtype=np.int64)  # bytes
        dropped = self._silenced
        self._silenced = 0
        # Whole bytes; the fraction that a tick leaves over goes to a later one.
        allowance = int((tick + 1) * self._bytes_per_tick) - int(tick * self._bytes_per_tick)
        for row, (radio, transmitter) in enumerate(zip(self._radios, self._transmitters, strict=True)):
            accepted, sent[row], refused = transmitter.send(outboxes.get(radio, ()), allowance, self._backlog_max)
            dropped += refused
            frames += accepted
            senders += [row] * len(accepted)
            if self._is_random and accepted:
                misses.append(self._rngs[row].random((len(accepted), 2, len(self._radios))))
        if frames:
            self._launch(tick, frames, np.array(senders), np.concatenate(misses) if misses else None, links)
        return RadioTraffic(
            frames=len(frames),
            bytes=int(sent.sum()),
            peak_bps=float(sent.max()) * BITS / self._period_s,
            neighborhood_bps=float(self._occupancy.note(tick, sent, links.connected).max()),
            dropped=dropped,
        )

    def silence(self, radio: NodeId) -> None:
        """Let a radio that died transmit no more: what it has not completed is dropped.

        Raises
        ------
        ValueError
            If there is no such radio.
        """
        self._silenced += self._transmitters[self._radios.index(radio)].clear()

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
        frames = np.array([frame for flight in flights for frame in flight.frames], dtype=np.object_)
        # Older flights stand first and the sort is stable, so each sender's frames stay in order of transmission.
        order = np.argsort(np.concatenate([flight.senders for flight in flights]), kind="stable")
        heard = np.concatenate([flight.heard for flight in flights])[order] & alive
        receivers, arrived = np.nonzero(heard.T)
        cuts = np.searchsorted(receivers, np.arange(len(self._radios) + 1)).tolist()
        arrived_frames = frames[order[arrived]].tolist()
        return [tuple(arrived_frames[a:b]) for a, b in pairwise(cuts)]

    @property
    def _is_random(self) -> bool:
        return self._config.loss > 0.0 or self._config.delay_ticks_max > 0

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
