"""The mission computer of a covering swarm: it radios the operator's orders, which the leader obeys."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.coverage_orders import CoverageOrder, encode_order
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs

OUTLINE_REFUSED = (
    "shape refused: this swarm fills solids, not outlines; its scenario can order another one (events: shape)"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class OrderConfig(Config):
    """How orders are given."""

    position_m: tuple[float, float, float] = setting(
        (0.0, 0.0, 0.0), "antenna of the mission computer: where the leader starts", unit="m"
    )
    repeat_ticks: int = setting(30, "between two repetitions of the last order", unit="ticks", minimum=1)


class OrderDesk:
    """Gives each order when it is due, and repeats the last one; nobody acknowledges.

    Parameters
    ----------
    config : OrderConfig
    schedule : sequence of (int, CoverageOrder)
        Tick in which an order is given, and the order; ascending in both.

    Raises
    ------
    FrameError
        If an order is too large for the radio.
    """

    def __init__(self, config: OrderConfig, schedule: Sequence[tuple[int, CoverageOrder]]) -> None:
        self._config = config
        self._schedule = [(tick, order.number, encode_order(order)) for tick, order in schedule]
        self._frames = self._bytes = 0

    @property
    def has_camera(self) -> bool:
        """Whether it looks at the robots from above: no."""
        return False

    def picture(self) -> ImageArray | None:
        """Return None, for it sees nothing."""
        return None

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        given = [entry for entry in self._schedule if entry[0] <= inputs.tick]
        outbox: tuple[bytes, ...] = ()
        if given:
            since, _, frame = given[-1]
            if (inputs.tick - since) % self._config.repeat_ticks == 0:
                outbox = (frame,)
        self._frames += len(outbox)
        self._bytes += sum(map(len, outbox))
        counters = RadioCounters(frames_sent=self._frames, bytes_sent=self._bytes)
        left = len(self._schedule) - len(given)
        report = MissionReport(
            epoch=given[-1][1] if given else 0,
            informed=(),
            reachable=(),
            parked=(),
            notice=OUTLINE_REFUSED if inputs.shape is not None else "",
            counters=counters,
            stage=max(0, len(given) - 1),
            stages_left=left,
        )
        return MissionOutputs(inputs.tick, outbox, None, report)
