from __future__ import annotations

import numpy as np
import pytest

from bringup.cross_checks import first_plan
from bringup.layout import robot_types, walls
from bringup.resolution import contour_of
from studies.lps_cells import Cell, Experiment, Motion, Trial
from studies.lps_formation import in_formation, run_formation, shape_of
from swarm_agent.localization.config import LpsMode
from swarm_msgs_py.roster import Roster
from swarm_sim.config import RangingModel

SHORT = Trial(robots=14, duration_s=12.0, warm_up_s=6.0)


def cell(mode: LpsMode = LpsMode.COOPERATIVE, **changes: object) -> Cell:
    return Cell(experiment=Experiment.FORMATION, mode=mode, **{"period_s": 0.0, **changes})  # type: ignore[arg-type]


def test_seeds_take_the_four_shapes_in_turn() -> None:
    assert [shape_of(seed) for seed in (1, 2, 3, 4, 5)] == [
        "formation_1", "formation_2", "formation_3", "formation_4", "formation_1",
    ]  # fmt: skip


def test_every_robot_stands_at_a_goal_of_its_type_and_no_goal_is_taken_twice() -> None:
    scenario = in_formation(cell(), 1, 14)
    types = robot_types(scenario)
    plan = first_plan(scenario, contour_of(scenario), Roster.of(types), walls(scenario))
    starts = scenario.robots.start.positions_m

    assert starts is not None
    standing = {(kind.type, *start) for kind, start in zip(types, starts, strict=True)}
    assert standing == {(int(kind), *goal) for kind, goal in zip(plan.goal_types, plan.goals.tolist(), strict=True)}


def test_a_cell_sets_what_sensors_do_and_what_filters_believe_of_them() -> None:
    scenario = in_formation(cell(LpsMode.LITERAL, sigma_m=3.0, period_s=5.0, share=0.5), 2, 14)

    assert scenario.sim.ranging.model is RangingModel.POSITION
    assert scenario.agent.lps.mode is LpsMode.LITERAL
    assert (scenario.sim.ranging.sigma_m, scenario.agent.lps.position_noise_sigma_m) == (3.0, 3.0)
    assert (scenario.agent.lps.range_sigma_m, scenario.agent.lps.period_s) == (3.0, 5.0)
    assert (scenario.robots.position_sensor_share, scenario.seed) == (0.5, 2)


def test_less_noise_and_more_beacons_make_smaller_errors() -> None:
    coarse, fine = (run_formation(cell(share=0.3, sigma_m=sigma), 1, SHORT).rms_m for sigma in (4.0, 0.2))

    assert coarse is not None
    assert fine is not None
    assert fine < 0.5 * coarse


def test_all_samples_after_the_warm_up_of_robots_without_sensor_count() -> None:
    scores = run_formation(cell(share=0.3), 1, SHORT)

    blind = 14 - 5  # three tenths, rounded up, are beacons
    assert scores.samples == blind * round((SHORT.duration_s - SHORT.warm_up_s) / 0.5)


@pytest.mark.parametrize("motion", [Motion.WANDER, Motion.PARKED])
def test_motion_is_no_reason_to_lose_oneself(motion: Motion) -> None:
    rest, other = (run_formation(cell(share=0.3, motion=m), 1, SHORT).max_m for m in (Motion.REST, motion))

    assert rest is not None
    assert other is not None
    assert np.isclose(rest, other, atol=0.5)


def test_a_robot_that_drives_and_ranges_almost_without_noise_is_where_it_says() -> None:
    scores = run_formation(cell(share=0.5, sigma_m=0.01, motion=Motion.WANDER), 1, SHORT)

    # In one tick a robot drives up to 0.25 m: estimates belong to the truth at the same instant.
    assert scores.rms_m is not None
    assert scores.max_m is not None
    assert scores.rms_m < 0.04
    assert scores.max_m < 0.1


def test_a_robot_that_knows_that_it_stands_knows_much_better_where() -> None:
    trial = Trial(robots=14, duration_s=60.0, warm_up_s=30.0)
    rest, parked = (
        run_formation(cell(share=0.3, period_s=3.0, motion=motion), 1, trial).rms_m
        for motion in (Motion.REST, Motion.PARKED)
    )

    assert rest is not None
    assert parked is not None
    assert parked < 0.6 * rest
