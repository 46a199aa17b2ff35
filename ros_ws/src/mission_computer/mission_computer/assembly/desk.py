"""The mission computer of assembling boats: plans, orders by radio, listens, and plans anew after losses."""

from __future__ import annotations

from dataclasses import dataclass

from mission_computer.assembly.foreman import Foreman, ForemanReport, ForemanState
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.boat_frames import BoatFrame, decode_boat_frame, is_boat_frame
from swarm_msgs_py.assembly.orders import GuidedOrders, Order, PlanOrders, TimedOrders, encode_order
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


OUTLINE_REFUSED = "shape refused: boats build the map of their scenario (map.name); start another run for another one"


class AssemblyDesk:
    """Plans and orders; one step per tick.

    Parameters
    ----------
    config : DeskConfig
    problem : AssemblyProblem
    plan : AssemblyPlan
        The first one, with timed paths or guideposts.
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
        report = self.report = self._foreman.step(inputs.tick, words, _ways(inputs.inbox))
        outbox = self._outbox(inputs.tick, report)
        self._frames += len(outbox)
        self._bytes += sum(map(len, outbox))
        informed = tuple(NodeId(boat) for boat, epoch in sorted(self._told.items()) if epoch == report.epoch)
        told = MissionReport(
            epoch=report.epoch,
            informed=informed,
            reachable=tuple(NodeId(boat) for boat in sorted(self._told)),
            parked=(),
            notice=OUTLINE_REFUSED if inputs.shape is not None else report.note,
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
            plan = foreman.plan
            self._order = encode_order(Order(foreman.epoch, _orders(foreman.problem, plan, foreman.epoch)))
            self._epoch, self._since = foreman.epoch, tick
            self.plans.append((foreman.problem, plan))
        if report.is_halting:
            return (encode_order(Order(report.epoch, None)),)
        everybody = range(foreman.problem.boat_count)
        is_known = all(self._told.get(boat) == self._epoch for boat in everybody)
        return () if is_known or (tick - self._since) % self._config.repeat_ticks else (self._order,)


def _orders(problem: AssemblyProblem, plan: AssemblyPlan, epoch: int) -> PlanOrders:
    """Return a plan as boats get it."""
    if plan.paths is not None:
        return TimedOrders(problem, plan.dispatch, plan.tree, plan.paths, epoch)
    if plan.guideposts is not None:
        return GuidedOrders(problem, plan.dispatch, plan.tree, plan.guideposts, epoch)
    raise AssemblyError(f"{problem.name}: boats need timed paths or guideposts")


def _ways(inbox: tuple[bytes, ...]) -> list[BoatFrame]:
    """Return the frames of boats that find their ways by themselves; what is damaged or foreign is ignored."""
    words = []
    for data in inbox:
        if is_boat_frame(data):
            try:
                words.append(decode_boat_frame(data))
            except FrameError:
                continue
    return words


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
