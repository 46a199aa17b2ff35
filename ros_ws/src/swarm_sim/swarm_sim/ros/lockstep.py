"""The loop that drives the world node: one tick after the other, never waiting forever."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from rclpy.executors import Executor
from rclpy.task import Future

from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.ros.spin import SLICE_S, spin_for
from swarm_msgs_py.types import NodeId, node_name
from swarm_sim.answers import Answers
from swarm_sim.ticked_world import Truth

ANSWER_SHARE = 0.7  # of a tick in real time, in which answers count; the rest is for physics and publishing
NAMED_MAX = 6  # nodes that one alert names


@dataclass(frozen=True, slots=True, kw_only=True)
class PaceConfig(Config):
    """How fast ticks follow each other."""

    real_time: bool = setting(False, "pace ticks by the wall clock and wait for nobody")
    deadline_s: float = setting(
        5.0,
        "wall time after which a node without an answer is silent; in lockstep it stands still while a node "
        "that is waited for is known to compute",
        unit="s",
        above=0.0,
    )
    first_deadline_s: float = setting(30.0, "the same in the first ticks, in which plans are made", unit="s", above=0.0)
    first_ticks: int = setting(10, "how many ticks the longer deadline holds", minimum=0)
    computing_limit_s: float = setting(
        120.0,
        "CPU time without an answer from anybody after which a node that computes is taken for one that hangs",
        unit="s",
        above=0.0,
    )


@dataclass(frozen=True, slots=True, eq=False)
class TickResult:
    """One tick as the world saw it.

    Attributes
    ----------
    truth : Truth
    answered : frozenset of NodeId
        Who answered in time.
    alerts : tuple of str
        Who fell silent, who is heard again, whom the operator killed, who died as the scenario says.
    lost : frozenset of NodeId
        Who is dead.
    """

    truth: Truth
    answered: frozenset[NodeId]
    alerts: tuple[str, ...]
    lost: frozenset[NodeId]


@dataclass(frozen=True, slots=True)
class Switched:
    """A node was switched off or on.

    Attributes
    ----------
    node : NodeId
    is_on : bool
    line : str
        What the operator reads.
    """

    node: NodeId
    is_on: bool
    line: str


class SteppedWorld(Protocol):
    """The world node, as the loop sees it."""

    period_s: float
    is_paused: bool
    answered: Future

    @property
    def tick(self) -> int:
        """Number of the current tick."""
        ...

    @property
    def off(self) -> tuple[NodeId, ...]:
        """Robots whose electronics are off, ascending."""
        ...

    @property
    def missing(self) -> tuple[NodeId, ...]:
        """Who is still waited for in this tick."""
        ...

    @property
    def is_deserted(self) -> bool:
        """Whether the whole swarm is silent, so that there is nobody to wait for."""
        ...

    def begin(self) -> None:
        """Publish everything that belongs to the current tick."""
        ...

    def finish(self) -> tuple[Truth, Answers]:
        """Apply what was answered and let the bodies move."""
        ...

    def bury(self, node: NodeId) -> None:
        """Take a dead node out of the run."""
        ...

    def take_switched(self) -> tuple[Switched, ...]:
        """Return, once, who was switched off or on, by the scenario or the operator."""
        ...


class Overseer(Protocol):
    """Who decides how long the world runs, and hears how it went."""

    def is_over(self) -> bool:
        """Return whether to stop; asked several times per second."""
        ...

    def may_begin(self, tick: int) -> bool:
        """Return whether a tick may start now; may wait for a short while."""
        ...

    def fallen(self) -> Iterable[NodeId]:
        """Return the nodes whose processes have died since the last call."""
        ...

    def computing_s(self, node: NodeId) -> float | None:
        """Return the CPU time that a node's process has used [s] if it computes at this moment.

        None if it does not, or if that is not known.
        """
        ...

    def report(self, result: TickResult) -> None:
        """Take in a tick that has run."""
        ...


class Lockstep:
    """Runs a world node tick by tick.

    Parameters
    ----------
    world : SteppedWorld
    executor : Executor
        Runs the world node, and maybe others.
    pace : PaceConfig
    overseer : Overseer
    """

    def __init__(self, world: SteppedWorld, executor: Executor, pace: PaceConfig, overseer: Overseer) -> None:
        self._world, self._executor, self._pace, self._overseer = world, executor, pace, overseer
        self._lost: set[NodeId] = set(world.off)
        self._began: float | None = None  # when the last tick began, for pacing
        self._alerts: list[str] = []
        self._was_deserted = False

    def run(self) -> None:
        """Run until the overseer, or ROS, says that it is over."""
        while not self._is_over():
            self._bury_fallen()
            if self._world.is_paused:
                self._began = None
                spin_for(self._executor, SLICE_S)
            elif self._overseer.may_begin(self._world.tick):
                self.run_tick()
            else:
                spin_for(self._executor, 0.0)

    def run_tick(self) -> None:
        """Run one tick, from publishing to the report."""
        start = self._wait_for_start()
        self._world.begin()
        self._note_switched()
        if self._pace.real_time:
            # From when all was told: a world that runs late must not become one that hears nobody, ever.
            self._await_answers_until(time.monotonic() + ANSWER_SHARE * self._world.period_s)
        else:
            self._await_answers()
            self._linger(start)
        self._note_switched()
        lost = frozenset(self._lost)
        truth, answers = self._world.finish()
        if answers.silenced:
            self._alerts.append(f"{_named(answers.silenced)} did not answer tick {truth.tick} in time; not waited for")
        if answers.recovered:
            self._alerts.append(f"{_named(answers.recovered)} answers again")
        alerts, self._alerts = tuple(self._alerts), []
        self._overseer.report(TickResult(truth, answers.complete, alerts, lost))

    def _note_switched(self) -> None:
        for switched in self._world.take_switched():
            (self._lost.discard if switched.is_on else self._lost.add)(switched.node)
            self._alerts.append(switched.line)

    def _is_over(self) -> bool:
        return self._overseer.is_over() or not self._executor.context.ok()

    def _bury_fallen(self) -> None:
        for node in self._overseer.fallen():
            self._lost.add(node)
            self._world.bury(node)  # also one that is off: it must not be switched on any more

    def _wait_for_start(self) -> float:
        """Return the wall time at which this tick begins: now, or in real time not before its turn."""
        now = time.monotonic()
        if not self._pace.real_time or self._began is None:
            self._began = now
            return now
        due = self._began + self._world.period_s
        while now < due and not self._is_over():
            spin_for(self._executor, min(SLICE_S, due - now))
            now = time.monotonic()
        # A world that cannot keep up falls behind the clock; it does not race to catch up.
        self._began = max(due, now - self._world.period_s)
        return self._began

    def _await_answers_until(self, deadline: float) -> None:
        """Run callbacks until all have answered, the deadline has passed or it is over.

        If the whole swarm is silent, nobody is waited for, but it is listened to: else it would remain so for a world
        that is too late to listen between two ticks.
        """
        while not self._is_over():
            left = deadline - time.monotonic()
            if left <= 0.0:
                return
            if self._world.is_deserted:
                spin_for(self._executor, min(SLICE_S, left))
            elif self._world.answered.done():
                return
            else:
                spin_for(self._executor, min(SLICE_S, left), self._world.answered)
            self._bury_fallen()

    def _await_answers(self) -> None:
        """Run callbacks until all have answered, the deadline of those who do not compute has passed, or it is over.

        How long a step takes must not decide what happens in simulated time, or equal seeds would give unequal runs. So
        the deadline is one for nodes that sleep, are stopped or have lost a message: while anybody who is waited for
        computes, it stands still.
        """
        left = self._pace.first_deadline_s if self._world.tick < self._pace.first_ticks else self._pace.deadline_s
        diligence = _Diligence(self._overseer, self._pace.computing_limit_s)
        while left > 0.0 and not self._world.answered.done() and not self._is_over():
            began, slice_s = time.monotonic(), min(SLICE_S, left)
            spin_for(self._executor, slice_s, self._world.answered)
            self._bury_fallen()
            if not diligence.is_any_computing(self._world.missing):
                left -= min(time.monotonic() - began, slice_s)  # not more: if this process was stopped, nobody was late

    def _linger(self, start: float) -> None:
        """If there is nobody to wait for, let the tick take its time, lest the world race on under robots that stand.

        Ends early as soon as somebody is heard again.
        """
        if self._world.is_deserted and not self._was_deserted:
            period = f"{self._world.period_s:g} s"
            self._alerts.append(f"the whole swarm is silent; until somebody answers, ticks take {period} of wall time")
        self._was_deserted = self._world.is_deserted
        left = start + self._world.period_s - time.monotonic()
        while self._world.is_deserted and left > 0.0 and not self._is_over():
            spin_for(self._executor, min(SLICE_S, left))
            self._bury_fallen()
            left = start + self._world.period_s - time.monotonic()


class _Diligence:
    """Tells who computes from who runs in circles, in one tick.

    The measure is CPU time, so that a crowded machine condemns nobody, and it begins anew with every answer, for the
    nodes of one process compute one after the other.
    """

    def __init__(self, overseer: Overseer, limit_s: float) -> None:
        self._overseer, self._limit_s = overseer, limit_s
        self._missing: tuple[NodeId, ...] = ()
        self._before: dict[NodeId, float] = {}

    def is_any_computing(self, missing: tuple[NodeId, ...]) -> bool:
        """Return whether any of those who are waited for computes, and has not done so for too long."""
        if missing != self._missing:
            self._missing, self._before = missing, {}
        for node in missing:
            used_s = self._overseer.computing_s(node)
            if used_s is not None and used_s - self._before.setdefault(node, used_s) < self._limit_s:
                return True
        return False


def _named(nodes: tuple[NodeId, ...]) -> str:
    names = [node_name(node) for node in nodes]
    rest = len(names) - NAMED_MAX
    return ", ".join(names[:NAMED_MAX]) + (f" and {rest} more" if rest > 0 else "")
