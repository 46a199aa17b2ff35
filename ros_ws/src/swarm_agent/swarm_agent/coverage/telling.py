"""What a robot tells its neighbors, and how boards become equal: news at once, everything where boards differ."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_agent.coverage.board import Board
from swarm_agent.coverage.config import ProtocolConfig
from swarm_agent.coverage.frames import Frame, Key, Mission, Place, TreeNews, encode
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.types import NodeId


class Telling:
    """The news of one robot that are not yet told.

    Parameters
    ----------
    me : NodeId
    protocol : ProtocolConfig
    """

    def __init__(self, me: NodeId, protocol: ProtocolConfig) -> None:
        self._me, self._protocol = me, protocol
        self._orders: list[bytes] = []
        self._tells_mission = False
        self.begin(Board(0.0))

    def begin(self, board: Board) -> None:
        """Speak of another board from now on: a swarm that gathers again begins with an empty one."""
        self._board = board
        self._news: dict[Key, Place] = {}
        self._differs = self._is_due = False
        self._changed_at = 0

    def hear(self, tick: int, frame: Frame, *, passes_on: bool, answers: bool) -> None:
        """Take the places of a neighbor's frame in.

        Parameters
        ----------
        tick : int
        frame : Frame
        passes_on : bool
            Whether to tell the others what is news.
        answers : bool
            Whether to send everything to a neighbor whose board differs. It must differ when both have been without
            news for a while, else news that are still on the air would make everybody send everything.
        """
        for place in frame.places:
            if self._board.merge(place):
                self._changed_at = tick
                if passes_on:
                    self._news[place.key] = place
        if answers and frame.is_heartbeat and frame.digest != self._board.digest and self._is_quiet(tick):
            self._differs = True

    def _is_quiet(self, tick: int) -> bool:
        return tick - self._changed_at >= self._protocol.quiet_ticks

    def say(self, place: Place, tick: int) -> None:
        """Put a record on the board, and tell it if it is news."""
        if self._board.merge(place):
            self.tell([place], tick)

    def tell(self, places: Iterable[Place], tick: int) -> None:
        """Tell records that are on the board already."""
        for place in places:
            self._news[place.key] = place
            self._changed_at = tick

    def tell_mission(self) -> None:
        """Tell the mission in the next frame."""
        self._tells_mission = True

    def pass_on(self, order: bytes) -> None:
        """Repeat an order as it was heard."""
        self._orders.append(order)

    def outbox(
        self, tick: int, mode: CoverageMode, mission: Mission, tree: TreeNews | None, *, has_changed: bool
    ) -> tuple[bytes, ...]:
        """Return what is sent in a tick: one frame or none, and orders to pass on.

        Parameters
        ----------
        tick : int
        mode : CoverageMode
        mission : Mission
        tree : TreeNews or None
            News of the rendezvous.
        has_changed : bool
            Whether the robot has begun something else.
        """
        protocol = self._protocol
        # A beat that falls among news is late, not left out: news that come as often as beats would hide a difference.
        self._is_due |= (tick + self._me) % protocol.heartbeat_ticks == 0
        beats = self._is_due and mode is not CoverageMode.GATHERING
        asks, self._differs = self._differs, False
        if asks:  # a robot that knows nothing is answered with everything
            self._news = {place.key: place for place in self._board.everything()}
            self._tells_mission = mission.term > 1
        heartbeat = asks or (beats and self._is_quiet(tick))
        self._is_due &= not heartbeat
        frames, self._orders = self._orders, []
        if has_changed or tree or self._news or self._tells_mission or heartbeat:
            news = tuple(self._news[key] for key in sorted(self._news))
            told = mission if self._tells_mission else None
            frames = [*frames, encode(Frame(self._me, mode, self._board.digest, heartbeat, news, tree, told))]
            self._news, self._tells_mission = {}, False
        return tuple(frames)
