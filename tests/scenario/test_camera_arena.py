"""The arena: five robots form shapes, knowing of the world only what images of them say."""

from __future__ import annotations

from functools import cache
from itertools import permutations

import numpy as np
import pytest

from bringup.compose import ScenarioActors
from bringup.inprocess import InProcessEngine
from bringup.layout import robot_types
from bringup.resolution import resolve
from bringup.results import FormationMetrics, Outcome, formation_metrics
from bringup.scenario import Scenario
from bringup.scenario_file import Override, load_scenario, parse_assignment
from studies.headless_mission import ENGINE, run_to_verdict
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import FloatArray, IntArray

TWO_SHAPES = (
    "sim.physics.backend=massdamper",
    "stages=[{shape: {name: hw_4_arrow, heading_deg: 90.0}}]",
    "robots.start.positions_m=null",
    "robots.start.half_side_m=0.8",
    "robots.start.gap_m=0.06",
    "duration_s=80",
)


def arena(seed: int, *assignments: str) -> Scenario:
    overrides = (Override("test", "seed", seed), *map(parse_assignment, assignments))
    return resolve(*load_scenario("arena", overrides))


@cache
def two_shapes(seed: int) -> tuple[Scenario, Outcome, FormationMetrics]:
    """Form a trapezoid from anywhere, and then an arrow in which all robots face north."""
    scenario = arena(seed, *TWO_SHAPES)
    outcome = run_to_verdict(scenario)
    return scenario, outcome, formation_metrics(scenario, ENGINE, outcome)


def test_both_shapes_are_formed_without_a_touch_by_what_the_camera_sees() -> None:
    _, _, metrics = two_shapes(3)

    assert metrics.achieved, metrics.reason
    assert metrics.collisions == 0
    assert metrics.stage_arrival_s is not None
    assert None not in metrics.stage_arrival_s
    assert (metrics.camera_detected_fraction, metrics.camera_false_fixes) == (1.0, 0)
    assert (metrics.camera_position_rmse_m or 1.0) < 0.004
    assert (metrics.camera_position_max_m or 1.0) < 0.012
    assert (metrics.camera_heading_rmse_deg or 9.0) < 2.0
    assert (metrics.localization_rmse_m or 1.0) < 0.004
    assert (metrics.heading_rmse_deg or 9.0) < 2.0


def test_robots_drive_hardly_farther_than_they_must() -> None:
    _, _, metrics = two_shapes(3)

    assert metrics.stage_displacement_m is not None
    assert metrics.stage_bound_m is not None
    assert sum(metrics.stage_displacement_m) < 1.05 * sum(bound or 0.0 for bound in metrics.stage_bound_m)


def cheapest(starts: FloatArray, goals: FloatArray, types: IntArray, goal_types: IntArray) -> float:
    """Return the least sum of beelines over all ways to share out goals within the types, by trying every one."""
    ways = np.linalg.norm(starts[:, None] - goals[None], axis=2)
    orders = (list(order) for order in permutations(range(len(goals))))
    return min(float(ways[range(len(goals)), order].sum()) for order in orders if (goal_types[order] == types).all())


def test_the_choice_of_goals_is_the_best_of_all_permutations_within_the_types() -> None:
    scenario, outcome, _ = two_shapes(3)
    trace, ordered = outcome.recorder.trace(), outcome.supervisor.stages
    types = np.array([kind.type for kind in robot_types(scenario)])

    for first, last in zip(ordered, [*ordered[1:], len(trace.tick_times)], strict=True):
        plan, chosen = outcome.supervisor.course.at(last - 1), trace.goals[last - 1]
        starts = trace.tick_positions[first]
        driven = float(np.linalg.norm(starts - plan.goals[chosen], axis=1).sum())
        best = cheapest(starts, plan.goals, types, plan.goal_types)
        assert sorted(chosen.tolist()) == list(range(5))
        assert (
            driven <= best + 0.004
        )  # what robots know of their places, and tell of their ways, is good to a millimeter


def test_robots_turn_as_ordered_and_hold_their_heading_until_then() -> None:
    _, outcome, _ = two_shapes(3)
    trace, (_, second) = outcome.recorder.trace(), outcome.supervisor.stages
    turned = np.abs(np.rad2deg(np.unwrap(trace.yaws, axis=0) - trace.yaws[0]))

    assert turned[:second].max() < 2.0
    assert np.rad2deg(trace.yaws[-1]) % 360.0 == pytest.approx(np.full(5, 90.0), abs=2.0)


def test_robots_stop_while_the_camera_is_off_or_half_blind_and_then_go_on() -> None:
    scenario = arena(
        4, "sim.physics.backend=massdamper", "stages=[]", "sim.camera.off_from_s=2.0", "sim.camera.off_for_s=2.0",
        "sim.camera.black_from_s=6.0", "sim.camera.black_for_s=1.0",
    )  # fmt: skip
    speeds, modes = [], []
    with InProcessEngine(ScenarioActors(scenario)) as engine:
        ticks = engine.ticks()
        for _ in range(80):
            record = next(ticks)
            speeds.append(np.hypot(*record.truth.velocities.T))
            modes.append([report.mode for _, report in sorted(record.reports.items())])

    def at(time: float) -> int:
        return round(time / 0.1)

    assert np.max(speeds[at(2.8) : at(4.0)]) < 1e-6
    assert all(mode is Mode.BLIND for mode in modes[at(3.0)])
    assert np.median(speeds[at(4.5)]) > 0.03
    hidden = np.array([mode is Mode.BLIND for mode in modes[at(6.9)]])
    assert 1 <= hidden.sum() <= 4  # the others are in the half that shows
    assert np.max(speeds[at(6.95)][hidden]) < 1e-6
    assert np.max(speeds[at(6.95)][~hidden]) > 0.03
    assert all(mode is not Mode.BLIND for mode in modes[at(7.5)])
