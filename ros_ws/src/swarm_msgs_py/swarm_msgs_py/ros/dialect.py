"""How the step contract of one family of behavior travels on ROS topics; the nodes are the same for all families."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from swarm_msgs_py.topics import RADIO_RX, Channel
from swarm_msgs_py.types import NodeId

InputsT = TypeVar("InputsT")
CommandT = TypeVar("CommandT")
ReportT = TypeVar("ReportT")


@dataclass(frozen=True, slots=True)
class Sense(Generic[InputsT]):
    """One kind of reading, and the topic that carries it.

    Attributes
    ----------
    part : int
        Its flag in the batch that says what belongs to a tick (`swarm_msgs_py.topics.Parts`).
    channel : Channel
    encode : callable
        Makes the message of a tick, from stamp, robot and inputs.
    decode : callable
        Returns tick and reading, from a message and the control period [s]; raises `MessageError`.
    is_there : callable
        Whether there is anything to say. What is empty stays unsaid: a message costs far more than its bytes do.
    tells_viewers : bool
        Whether it is said nevertheless while somebody beside the robot listens.
    """

    part: int
    channel: Channel
    encode: Callable[[bytes, NodeId, InputsT], bytes]
    decode: Callable[[bytes, float], tuple[int, Any]]
    is_there: Callable[[InputsT], bool]
    tells_viewers: bool = False


@dataclass(frozen=True, slots=True)
class Dialect(Generic[InputsT, CommandT, ReportT]):
    """All that nodes must know of a family.

    Attributes
    ----------
    senses : tuple of Sense
    required : int
        Parts without which no tick is complete.
    join : callable
        Makes the inputs of a tick from its number, time [s], readings by part, and frames heard.
    encode_command, decode_command : callable
        Of ``cmd_vel``: from stamp, robot and command to a message, and back to time [s] and command.
    views : tuple
        Channels for viewers, and what makes their messages of robot, time [s] and report.
    """

    senses: tuple[Sense[InputsT], ...]
    required: int
    join: Callable[[int, float, Mapping[int, Any], tuple[bytes, ...]], InputsT]
    encode_command: Callable[[bytes, NodeId, CommandT], bytes]
    decode_command: Callable[[bytes], tuple[float, CommandT]]
    views: tuple[tuple[Channel, Callable[[NodeId, float, ReportT], Any]], ...]

    @property
    def sensors(self) -> tuple[Channel, ...]:
        """What the world sends to each robot."""
        return (*(sense.channel for sense in self.senses), RADIO_RX)

    @property
    def shown(self) -> tuple[Channel, ...]:
        """What each robot shows to viewers."""
        return tuple(channel for channel, _ in self.views)
