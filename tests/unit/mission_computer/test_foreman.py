"""The foreman's verdict: it claims a proof only for what the solver has proven."""

from __future__ import annotations

from collections.abc import Collection

import pytest
from assembly_problems import ALL_SIDES, block, problem_of

from mission_computer.assembly import foreman as watching
from mission_computer.assembly.foreman import Foreman, ForemanReport, ForemanState
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.progress_frames import NO_DEPARTURE, ProgressFrame

SILENCE = 8
PROBLEM = problem_of(block(2, 2), [ALL_SIDES] * 4)


def hear(foreman: Foreman, ticks: range, boats: Collection[int]) -> ForemanReport:
    """Let boats that stand at their starts tell so, and stop when they are told to."""
    report = foreman.step(ticks[0], ())
    for tick in ticks[1:]:
        halted = report.is_halting
        frames = [ProgressFrame(b, foreman.epoch, 0, NO_DEPARTURE, frozenset(), halted, False) for b in boats]
        report = foreman.step(tick, frames)
    return report


def test_giving_up_halfway_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plan for three boats was proven to be the largest; that not even it was built is no proof at all."""
    monkeypatch.setattr(watching, "REPLANS_MAX", 1)
    plan = plan_with_timed_paths(PROBLEM, 1, TimedPlannerLimits())
    foreman = Foreman(PROBLEM, plan, 1, SILENCE, TimedLimits(attempts=4))

    first = hear(foreman, range(40), (0, 1, 2))
    second = hear(foreman, range(40, 80), (0, 1))

    assert (first.state, first.epoch) == (ForemanState.WATCHING, 2)
    assert second.state is ForemanState.GAVE_UP
    assert second.note.endswith("finished the largest connected sub-structure: 1 of 4 (best found)")
