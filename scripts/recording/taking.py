"""Takes serialized messages as they come, writes them, and keeps account of which ticks of each topic there are."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from recording.stamps import time_of
from recording.tick_ranges import TickRanges
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.ros import convert
from swarm_msgs_py.topics import (
    BOAT,
    CAMERA_IMAGE,
    CAMERA_INFO,
    CLOCK,
    FIX,
    IMU,
    NEIGHBORS,
    PROXIMITY,
    RADIO_RX,
    RANGES,
    Channel,
    Parts,
)

CHANNELS_OF_PART = {
    Parts.IMU: (IMU,),
    Parts.FIX: (FIX,),
    Parts.RANGES: (RANGES,),
    Parts.PROXIMITY: (PROXIMITY,),
    Parts.IMAGE: (CAMERA_IMAGE, CAMERA_INFO),
    Parts.NEIGHBORS: (NEIGHBORS,),
    Parts.BOAT: (BOAT,),
}
"""What each announced part of a tick is; a part that nobody counts could be lost unnoticed."""

STRAY_S = 10.0
"""A message that says to be farther than this from the clock goes by another clock [s]."""


class Sink(Protocol):
    """Where messages go."""

    def write(self, topic: str, time: float, data: bytes) -> None:
        """Append a message of a time [s]."""
        ...


@dataclass(slots=True)
class Account:
    """What a recording holds.

    Attributes
    ----------
    taken : mapping of str to TickRanges
        By topic, the ticks of which there are messages.
    promised : mapping of str to TickRanges
        By topic, the ticks in which a robot was told that there is a message for it: radio batches say so of the
        readings beside them.
    messages : int
        How many messages there are.
    """

    taken: Mapping[str, TickRanges] = field(default_factory=dict)
    promised: Mapping[str, TickRanges] = field(default_factory=dict)
    messages: int = 0


class Taking:
    """Sorts and counts what is recorded.

    Parameters
    ----------
    sink : Sink
    channels : mapping of str to Channel
        By topic.
    period_s : float
        Duration of a tick [s].

    Attributes
    ----------
    account : Account
    tick : int
        The last tick that the clock has announced, -1 before.
    """

    def __init__(self, sink: Sink, channels: Mapping[str, Channel], period_s: float) -> None:
        self._sink, self._channels, self._period = sink, channels, period_s
        self._time = 0.0
        self.account = Account({topic: TickRanges() for topic in channels}, {topic: TickRanges() for topic in channels})
        self.tick = -1

    def take(self, topic: str, data: bytes) -> None:
        """Write a message; one that does not say when it was true counts as of now.

        Raises
        ------
        OSError
            If the disk does not take it.
        """
        channel = self._channels[topic]
        try:
            stated = time_of(channel, data, self._period)
        except (SwarmError, IndexError):  # somebody else speaks on the topic; what was said is kept as it is
            stated = None
        if channel is not CLOCK and stated is not None and not self._is_of_this_run(stated):
            stated = None
        time = self._time if stated is None else stated
        tick = round(time / self._period)
        if channel is CLOCK:
            self._time, self.tick = max(self._time, time), max(self.tick, tick)
        elif channel is RADIO_RX and stated is not None:
            self._note_promises(topic, data, tick)
        self.account.taken[topic].add(tick)
        self.account.messages += 1
        self._sink.write(topic, time, data)

    def _is_of_this_run(self, stated: float) -> bool:
        return stated >= 0.0 and abs(stated - self._time) <= STRAY_S

    def _note_promises(self, topic: str, data: bytes, tick: int) -> None:
        flags, node = convert.decode_frames(data).flags, topic.split("/")[1]
        for part, channels in CHANNELS_OF_PART.items():
            for channel in channels if flags & part else ():
                self.account.promised[channel.template.format(node=node)].add(tick)
