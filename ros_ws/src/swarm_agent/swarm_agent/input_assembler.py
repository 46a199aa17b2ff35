"""Joins the messages of one tick, which arrive in any order, into the inputs of one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from swarm_msgs_py.frames import Batch

PENDING_MAX = 200
"""Unfinished ticks that are kept; a tick of which a part was lost is never finished."""

InputsT = TypeVar("InputsT")


@dataclass(slots=True)
class _Tick:
    """What has come of one tick so far."""

    heard: int = 0
    batch: Batch | None = None
    readings: dict[int, Any] = field(default_factory=dict)


class InputAssembler(Generic[InputsT]):
    """Collects the parts of ticks; a tick is complete with its batch and every part that the batch announces.

    Parameters
    ----------
    period_s : float
        Control period [s].
    join : callable
        Makes the inputs of a tick from its number, time [s], readings by part, and frames heard.
    required : int
        Parts that every tick has, whatever its batch announces.
    """

    def __init__(
        self,
        period_s: float,
        join: Callable[[int, float, Mapping[int, Any], tuple[bytes, ...]], InputsT],
        required: int = 0,
    ) -> None:
        self._period, self._join, self._required = period_s, join, required
        self._pending: dict[int, _Tick] = {}

    def put(self, part: int, tick: int, reading: Any) -> InputsT | None:
        """Take one reading of a tick; return the inputs if they are complete now."""
        pending = self._of(tick)
        pending.readings[part] = reading
        pending.heard |= part
        return self._joined(tick, pending)

    def put_batch(self, batch: Batch) -> InputsT | None:
        """Take the radio frames of a tick; return the inputs if they are complete now."""
        pending = self._of(batch.tick)
        pending.batch = batch
        return self._joined(batch.tick, pending)

    def _of(self, tick: int) -> _Tick:
        if tick not in self._pending:
            while len(self._pending) >= PENDING_MAX:
                del self._pending[min(self._pending)]
            self._pending[tick] = _Tick()
        return self._pending[tick]

    def _joined(self, tick: int, pending: _Tick) -> InputsT | None:
        """Return the inputs and forget everything older if nothing is missing."""
        batch = pending.batch
        if batch is None or (batch.flags | self._required) & ~pending.heard:
            return None
        self._pending = {later: rest for later, rest in self._pending.items() if later > tick}
        return self._join(tick, tick * self._period, pending.readings, batch.frames)
