"""Shapes that follow each other, move, part and join, and robots that move along."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from moving_swarm import Ran, moving_scenario, ran

from bringup.scenario import Scenario
from bringup.stage_results import motion_results
from swarm_agent.decision.consensus import Consensus
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.trace import TraceRecorder

MORPH = "[{shape: {points: [[-8, -2], [8, -2], [8, 2], [-8, 2]]}, over_s: 15.0}]"
SHIFT = "[{translate_m: [6.0, 2.0], over_s: 30.0}]"
LOSS = ("events=[{at_s: 24.0, kill: [4]}]", "lost_after_s=4", "regroup_pause_s=2")
METHODS = ("bubble-packing", "voronoi", "forces")


def goals_taken(run: Ran, epoch: int) -> dict[NodeId, set[int]]:
    """Return the goals that each robot reported while it held a plan."""
    taken: dict[NodeId, set[int]] = {}
    for record in run.records:
        for robot, report in record.reports.items():
            if report.epoch == epoch:
                taken.setdefault(robot, set()).add(report.goal)
    return taken


def lag_of(scenario: Scenario, run: Ran) -> float:
    """Return the lag behind the shape in the motions of a run [s]."""
    robots = tuple(NodeId(robot) for robot in range(scenario.robots.count))
    recorder = TraceRecorder(robots, scenario.sim.period_s)
    for record in run.records:
        recorder.record(record.truth, record.reports)
    results = motion_results(recorder.trace(), run.supervisor.course, scenario.sim.period_s, np.ones(len(robots), bool))
    assert results is not None
    return results.latency_s


@dataclass(frozen=True, eq=False)
class Offered(Ran):
    """A run to its verdict, and the epoch under which each cost row was offered."""

    epochs: tuple[int, ...]


@pytest.fixture(scope="module", params=METHODS)
def morphed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Offered:
    """Return a run of a square that turns into a bar, under each method."""
    epochs: list[int] = []
    offer = Consensus.offer

    def noted(self: Consensus, *args: Any, **options: Any) -> None:
        epochs.append(self.book.epoch)
        offer(self, *args, **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Consensus, "offer", noted)
        run = ran(moving_scenario(tmp_path_factory.mktemp("morph"), MORPH, method=request.param))
    return Offered(run.records, run.supervisor, run.verdict, tuple(epochs))


def test_a_shape_turns_into_another_one_and_nobody_is_outside_on_the_way(morphed: Offered) -> None:
    run = morphed

    assert run.verdict.achieved, run.verdict.reason
    assert run.verdict.reason.startswith("last of 2 shapes formed: 9 of 9 robots")
    first, second = run.plans
    assert second.motion is not None
    assert second.motion.ticks == 30
    np.testing.assert_array_equal(second.motion.start, first.contour)
    assert len(run.outside_in_motion()) == 31
    assert max(run.outside_in_motion()) == 0.0
    assert all(record.truth.overlaps == () for record in run.records)


def test_everybody_keeps_its_goal_and_says_nothing_more_about_costs(morphed: Offered) -> None:
    run, has_goals = morphed, morphed.plans[0].task.has_goals
    before, after = goals_taken(run, 1), goals_taken(run, 2)
    assert {robot: {max(goals)} for robot, goals in before.items()} == after  # -1 until the first rows are there
    assert [plan.follows for plan in run.plans] == ([0, 1] if has_goals else [0, 0])
    assert Counter(run.epochs) == ({1: 9} if has_goals else {})


def test_two_shapes_follow_each_other_under_a_method_that_knows_no_motion(tmp_path: Path) -> None:
    stages = "[{shape: {name: hw_3_pentagon, scale: 10.0, translation_m: [5.0, 5.0]}}]"
    run = ran(moving_scenario(tmp_path, stages, method="fractals"))

    assert run.verdict.achieved, run.verdict.reason
    assert [plan.motion for plan in run.plans] == [None, None]
    assert run.supervisor.stages[0] == 0
    ordered = run.records[run.supervisor.stages[1]]
    assert ordered.plan is run.plans[1]
    assert all(report.mode is Mode.PARKED for report in run.records[ordered.tick - 1].reports.values())


def test_a_shape_parts_in_two_and_closes_again(tmp_path: Path) -> None:
    stages = "[{split: {gap_m: 3.0}, over_s: 10.0}, {join: true, over_s: 10.0, hold_s: 1.0}]"
    run = ran(moving_scenario(tmp_path, stages, method="voronoi"))

    assert run.verdict.achieved, run.verdict.reason
    assert max(run.outside_in_motion()) == 0.0
    whole, halves, again = run.plans
    np.testing.assert_array_equal(whole.contour, again.contour)
    assert np.abs(halves.goals[:, 0]).min() > 1.5  # nobody in the gap
    assert [plan.follows for plan in run.plans] == [0, 1, 1]
    assert goals_taken(run, 2) == goals_taken(run, 3)


def test_a_shape_is_shifted_and_turned(tmp_path: Path) -> None:
    run = ran(moving_scenario(tmp_path, "[{translate_m: [5.0, 2.0], over_s: 15.0}, {rotate_deg: 90.0, over_s: 20.0}]"))

    assert run.verdict.achieved, run.verdict.reason
    assert max(run.outside_in_motion()) == 0.0
    first, shifted, turned = run.plans
    np.testing.assert_allclose(shifted.goals - first.goals, np.tile([5.0, 2.0], (9, 1)), atol=0.011)
    assert turned.motion is not None
    assert turned.motion.rotation_rad == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(turned.contour.mean(axis=0), [5.0, 2.0], atol=0.01)


@pytest.mark.parametrize("method", ["bubble-packing", "forces"])
def test_after_a_loss_on_the_way_the_others_move_on(method: str, tmp_path: Path) -> None:
    run = ran(moving_scenario(tmp_path, SHIFT, *LOSS, method=method))

    assert run.verdict.achieved, run.verdict.reason
    assert run.alerts == ["r04 dies, as the scenario says", "r04 is lost; new plan for 8 robots"]
    _, moving, others = run.plans
    assert moving.motion is not None
    assert others.motion is not None
    assert moving.motion.begins < others.motion.begins < moving.motion.ends <= others.motion.ends
    np.testing.assert_array_equal(others.contour, moving.contour)
    assert others.robot_count == 8
    assert max(run.outside_in_motion()) == 0.0


def test_a_mission_computer_that_is_off_owes_the_shapes_to_come(tmp_path: Path) -> None:
    off = "events=[{at_s: 5.0, stop: mission_computer}]"
    run = ran(moving_scenario(tmp_path, MORPH, off))

    assert not run.verdict.achieved
    assert "9 of 9 robots at their goals, at rest since" in run.verdict.reason
    assert run.verdict.reason.endswith("; 1 stage to come, but the mission computer is off")


def test_a_motion_that_was_told_goes_on_without_the_mission_computer(tmp_path: Path) -> None:
    early = "[{shape: {points: [[-8, -2], [8, -2], [8, 2], [-8, 2]]}, over_s: 15.0, at_s: 14.0}]"
    run = ran(moving_scenario(tmp_path, early, "events=[{at_s: 16.0, stop: mission_computer}]"))

    assert run.verdict.achieved, run.verdict.reason
    assert max(run.outside_in_motion()) == 0.0


def test_forces_that_see_the_shape_ahead_of_time_do_not_lag(tmp_path: Path) -> None:
    scenario = moving_scenario(tmp_path, SHIFT.replace("30.0", "20.0"), method="forces")
    blind = replace(scenario, agent=replace(scenario.agent, forces=replace(scenario.agent.forces, foresight_s=0.0)))

    lags = [lag_of(each, ran(each)) for each in (scenario, blind)]

    assert lags[0] <= 0.5
    assert lags[1] >= 1.5
