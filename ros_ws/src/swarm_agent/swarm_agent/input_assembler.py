"""Joins the messages of one tick, which arrive in any order, into one `AgentInputs`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from swarm_msgs_py.frames import Batch
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import FloatArray

PENDING_MAX = 200
"""Unfinished ticks that are kept; a tick of which a part was lost is never finished."""


# Plain numbers: arithmetic on enumeration members costs ten times as much, five times per robot and tick.
_IMU, _FIX, _RANGES, _PROXIMITY = (int(part) for part in (Parts.IMU, Parts.FIX, Parts.RANGES, Parts.PROXIMITY))


@dataclass(slots=True)
class _Tick:
    """What has come of one tick so far."""

    heard: int = 0
    batch: Batch | None = None
    imu: ImuSample | None = None
    fix: PositionFix | None = None
    ranges: RangeScan = field(default_factory=lambda: RangeScan(np.zeros(0, dtype=np.int64), np.zeros(0)))
    proximity: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))


class InputAssembler:
    """Collects the parts of ticks; a tick is complete with its batch and every part that the batch announces.

    Parameters
    ----------
    period_s : float
        Control period [s].
    """

    def __init__(self, period_s: float) -> None:
        self._period = period_s
        self._pending: dict[int, _Tick] = {}

    def put_imu(self, tick: int, sample: ImuSample) -> AgentInputs | None:
        """Take the inertial sample of a tick; return the inputs if they are complete now."""
        pending = self._of(tick)
        pending.imu = sample
        return self._joined(tick, pending, _IMU)

    def put_fix(self, tick: int, fix: PositionFix) -> AgentInputs | None:
        """Take the position fix of a tick; return the inputs if they are complete now."""
        pending = self._of(tick)
        pending.fix = fix
        return self._joined(tick, pending, _FIX)

    def put_ranges(self, tick: int, scan: RangeScan) -> AgentInputs | None:
        """Take the range scan of a tick; return the inputs if they are complete now."""
        pending = self._of(tick)
        pending.ranges = scan
        return self._joined(tick, pending, _RANGES)

    def put_proximity(self, tick: int, points: FloatArray) -> AgentInputs | None:
        """Take the (n, 2) proximity points of a tick; return the inputs if they are complete now."""
        pending = self._of(tick)
        pending.proximity = points
        return self._joined(tick, pending, _PROXIMITY)

    def put_batch(self, batch: Batch) -> AgentInputs | None:
        """Take the radio frames of a tick; return the inputs if they are complete now."""
        pending = self._of(batch.tick)
        pending.batch = batch
        return self._joined(batch.tick, pending, 0)

    def _of(self, tick: int) -> _Tick:
        if tick not in self._pending:
            while len(self._pending) >= PENDING_MAX:
                del self._pending[min(self._pending)]
            self._pending[tick] = _Tick()
        return self._pending[tick]

    def _joined(self, tick: int, pending: _Tick, part: int) -> AgentInputs | None:
        """Note that `part` has come; return the inputs and forget everything older if nothing is missing."""
        pending.heard |= part
        batch, imu = pending.batch, pending.imu
        if batch is None or imu is None or batch.flags & ~pending.heard:
            return None
        self._pending = {later: rest for later, rest in self._pending.items() if later > tick}
        return AgentInputs(
            tick=tick,
            time=tick * self._period,
            imu=imu,
            fix=pending.fix,
            ranges=pending.ranges,
            proximity=pending.proximity,
            inbox=batch.frames,
        )
