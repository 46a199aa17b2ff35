"""Who has answered a tick, and with what: the world's half of the lockstep, without any clock or message."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from swarm_msgs_py.types import MISSION, NodeId


@dataclass(frozen=True, slots=True)
class Answers:
    """What came in for one tick.

    Attributes
    ----------
    commands : mapping of NodeId to the commands of the family
    outboxes : mapping of NodeId to tuple of bytes
        Frames of this tick, after those that came too late for the tick before.
    complete : frozenset of NodeId
        Nodes from which everything came.
    silenced, recovered : tuple of NodeId
        Who fell silent with this tick, and who was silent and has been heard again; ascending.
    """

    commands: Mapping[NodeId, Any]
    outboxes: Mapping[NodeId, tuple[bytes, ...]]
    complete: frozenset[NodeId]
    silenced: tuple[NodeId, ...]
    recovered: tuple[NodeId, ...]


class AnswerBook:
    """Collects the answers of robots and of the mission computer, tick by tick.

    A node that let a tick pass is *silent*: it is not waited for until it is heard again, so that a node that hangs
    costs one deadline, not one per tick. A late command is out of date and dropped; late radio frames are still good
    and go out with the next tick.

    Parameters
    ----------
    nodes : iterable of NodeId
        Robots, and `MISSION`.
    """

    def __init__(self, nodes: Iterable[NodeId]) -> None:
        self._live = set(nodes)
        self._silent: set[NodeId] = set()
        self._heard: set[NodeId] = set()
        self._tick = -1
        self._missing: set[NodeId] = set()
        self._commands: dict[NodeId, Any] = {}
        self._outboxes: dict[NodeId, tuple[bytes, ...]] = {}
        self._late: dict[NodeId, tuple[bytes, ...]] = {}

    @property
    def is_complete(self) -> bool:
        """Whether nobody is left to wait for."""
        return not self._missing

    @property
    def missing(self) -> tuple[NodeId, ...]:
        """Who is still waited for, ascending."""
        return tuple(sorted(self._missing))

    @property
    def is_deserted(self) -> bool:
        """Whether all robots that live are silent and none has been heard since the last tick.

        Without robots that live, the same of the mission computer.
        """
        expected = self._live - {MISSION} or self._live
        return bool(expected) and expected <= self._silent - self._heard

    def open(self, tick: int, asked: Collection[NodeId] | None = None) -> None:
        """Begin to collect the answers of a tick, from those who are `asked`; None: from all."""
        self._tick = tick
        self._missing = self._live - self._silent if asked is None else (self._live & set(asked)) - self._silent
        self._commands, self._outboxes = {}, {}

    def put_command(self, robot: NodeId, tick: int, command: Any) -> None:
        """Take a robot's command for a tick."""
        self._heard.add(robot)
        if tick == self._tick and robot in self._live:
            self._commands[robot] = command
            self._check(robot)

    def put_frames(self, node: NodeId, tick: int, frames: tuple[bytes, ...]) -> None:
        """Take the radio frames that a node sent in a tick."""
        self._heard.add(node)
        if node not in self._live or tick > self._tick:
            return
        if tick < self._tick:
            self._late[node] = self._late.get(node, ()) + frames
            return
        self._outboxes[node] = frames
        self._check(node)

    def remove(self, node: NodeId) -> None:
        """Expect nothing more from a node that is dead."""
        for members in (self._live, self._missing, self._silent):
            members.discard(node)
        self._commands.pop(node, None)
        self._outboxes.pop(node, None)
        self._late.pop(node, None)

    def add(self, node: NodeId) -> None:
        """Expect answers from a node that is switched on, from the next tick on."""
        self._live.add(node)

    def close(self) -> Answers:
        """End the tick and return what has come in; whoever is missing is silent from now on."""
        complete = frozenset(self._outboxes) & (frozenset(self._commands) | {MISSION})
        recovered = self._silent & self._heard
        silenced = self._missing
        self._silent = (self._silent - recovered) | silenced
        outboxes = {
            node: self._late.get(node, ()) + self._outboxes.get(node, ())
            for node in sorted(self._outboxes.keys() | self._late.keys())
        }
        commands = dict(sorted(self._commands.items()))
        self._missing, self._heard, self._late = set(), set(), {}
        self._tick += 1  # what still comes for this tick is late, also before the next one is opened
        return Answers(commands, outboxes, complete, tuple(sorted(silenced)), tuple(sorted(recovered)))

    def _check(self, node: NodeId) -> None:
        if node in self._outboxes and (node == MISSION or node in self._commands):
            self._missing.discard(node)
