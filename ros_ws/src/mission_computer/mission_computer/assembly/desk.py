"""The mission computer of assembling boats: plans, orders by radio, listens, and plans anew after losses."""

from __future__ import annotations

from dataclasses import dataclass

from mission_computer.assembly.foreman import Foreman, ForemanReport, ForemanState
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.orders import Order, TimedOrders, encode_order
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.assembly.progress_frames import ProgressFrame, decode_progress_frame, is_progress_frame
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.errors import AssemblyError, FrameError
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.types import NodeId


@dataclass(frozen=True, slots=True, kw_only=True)
class DeskConfig(Config):
    """How the mission computer leads an assembly."""

    repeat_ticks: int = setting(
        4,
        "between two repetitions of a plan that not everybody has confirmed; stops are told in every tick",
        minimum=1,
    )
    silence_s: float = setting(
        5.0, "a boat that was not heard for so long is taken for dead", unit="s", minimum=1.0, maximum=600.0
    )


class AssemblyDesk:
    """Plans and orders; one step per tick.

    Parameters
    ----------
    config : DeskConfig
    problem : AssemblyProblem
    plan : AssemblyPlan
        The first one, with timed paths.
    seed : int
        Of further plans.
    period_s : float
        Control period [s].
    """

    def __init__(
        self, config: DeskConfig, problem: AssemblyProblem, plan: AssemblyPlan, seed: int, period_s: float
    ) -> None:
        self._config = config
        self._foreman = Foreman(problem, plan, seed, round(config.silence_s / period_s), TimedLimits())
        self._told: dict[int, int] = {}  # epoch that each boat follows
        self._epoch = 0
        self._since = 0
        self._order = b""
        self._frames = self._bytes = 0
        self.plans: list[tuple[AssemblyProblem, AssemblyPlan]] = []
        self.report: ForemanReport | None = None

    @property
    def has_camera(self) -> bool:
        """Whether it looks at the boats from above: no."""
        return False

    def picture(self) -> ImageArray | None:
        """Return None, for it sees nothing."""
        return None

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        words = _words(inputs.inbox)
        self._told |= {word.boat: word.epoch for word in words}
        report = self.report = self._foreman.step(inputs.tick, words)
        outbox = self._outbox(inputs.tick, report)
        self._frames += len(outbox)
        self._bytes += sum(map(len, outbox))
        informed = tuple(NodeId(boat) for boat, epoch in sorted(self._told.items()) if epoch == report.epoch)
        told = MissionReport(
            epoch=report.epoch,
            informed=informed,
            reachable=tuple(NodeId(boat) for boat in sorted(self._told)),
            parked=(),
            notice=report.note,
            counters=RadioCounters(frames_sent=self._frames, bytes_sent=self._bytes),
        )
        return MissionOutputs(inputs.tick, outbox, None, told)

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be ordered."""
        return self.report is not None and self.report.state in (ForemanState.DONE, ForemanState.GAVE_UP)

    def _outbox(self, tick: int, report: ForemanReport) -> tuple[bytes, ...]:
        foreman = self._foreman
        if foreman.epoch != self._epoch:
            if foreman.plan.paths is None:
                raise AssemblyError(f"{foreman.problem.name}: boats need timed paths")
            plan = foreman.plan
            orders = TimedOrders(foreman.problem, plan.dispatch, plan.tree, foreman.plan.paths, foreman.epoch)
            self._order = encode_order(Order(foreman.epoch, orders))
            self._epoch, self._since = foreman.epoch, tick
            self.plans.append((foreman.problem, plan))
        if report.is_halting:
            return (encode_order(Order(report.epoch, None)),)
        everybody = range(foreman.problem.boat_count)
        is_known = all(self._told.get(boat) == self._epoch for boat in everybody)
        return () if is_known or (tick - self._since) % self._config.repeat_ticks else (self._order,)


def _words(inbox: tuple[bytes, ...]) -> list[ProgressFrame]:
    """Return the progress frames; what is damaged or foreign is ignored."""
    words = []
    for data in inbox:
        if is_progress_frame(data):
            try:
                words.append(decode_progress_frame(data))
            except FrameError:
                continue
    return words
