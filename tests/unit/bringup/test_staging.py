"""What each stage of a scenario makes of the shape before it, and which stages are refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from moving_swarm import moving_scenario

from bringup.compose import ScenarioActors
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve, stages_of, written_out
from bringup.scenario import Scenario
from bringup.scenario_file import dump_scenario, load_scenario
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area
from swarm_msgs_py.types import FloatArray

MORPH = "{shape: {points: [[-8, -2], [8, -2], [8, 2], [-8, 2]]}, over_s: 15.0}"


def contours(folder: Path, stages: str) -> list[FloatArray]:
    return [stage.contour for stage in stages_of(moving_scenario(folder, stages))]


def refusal(folder: Path, stages: str, *settings: str, method: str = "bubble-packing") -> str:
    with pytest.raises(ConfigError) as error:
        moving_scenario(folder, stages, *settings, method=method)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_transforms_are_of_the_shape_before_them(tmp_path: Path) -> None:
    moved, larger, turned = contours(tmp_path, "[{translate_m: [3.0, 1.0]}, {scale: 1.5}, {rotate_deg: 45.0}]")

    np.testing.assert_allclose(moved, [[-1, -3], [7, -3], [7, 5], [-1, 5]])
    np.testing.assert_allclose(larger, [[-3, -5], [9, -5], [9, 7], [-3, 7]])
    np.testing.assert_allclose(area_centroid(turned), [3.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(turned[0], [3.0, 1.0 - 6.0 * math.sqrt(2.0)], atol=1e-9)


def test_a_join_undoes_the_split_wherever_the_halves_have_gone(tmp_path: Path) -> None:
    stages = "[{split: {direction_deg: 90.0, gap_m: 2.0}}, {translate_m: [3.0, 1.0]}, {join: true}]"
    halves, moved, whole = contours(tmp_path, stages)

    assert signed_area(halves) == pytest.approx(64.0, abs=0.1)
    assert np.ptp(halves[:, 1]) == pytest.approx(10.0)
    np.testing.assert_allclose(moved, halves + np.array([3.0, 1.0]))
    np.testing.assert_allclose(whole, [[-1, -3], [7, -3], [7, 5], [-1, 5]])


def test_a_resolved_scenario_needs_no_other_and_resolves_to_itself(tmp_path: Path) -> None:
    stages = f"[{MORPH}, {{rotate_deg: 90.0, over_s: 20.0, at_s: 60.0}}, {{split: {{}}}}, {{join: true, hold_s: 7.0}}]"
    scenario = moving_scenario(tmp_path, stages)
    copy = tmp_path / "copy.yaml"
    copy.write_text(dump_scenario(scenario), encoding="utf-8")

    again = resolve(*load_scenario(str(copy)))

    assert again == scenario
    assert dump_scenario(again) == dump_scenario(scenario)
    told = [(stage.over_s, stage.rotation_rad, stage.at_s, stage.hold_s) for stage in stages_of(again)]
    assert told == [
        (15.0, 0.0, None, 3.0),
        (20.0, math.pi / 2, 60.0, 3.0),
        (0.0, 0.0, None, 3.0),
        (0.0, 0.0, None, 7.0),
    ]
    assert written_out(*load_scenario(str(tmp_path / "moving.yaml"))) == scenario


def test_files_of_stages_are_relative_to_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "bar.json").write_text("[[-6, -2], [6, -2], [6, 2], [-6, 2]]")

    (bar,) = contours(tmp_path, "[{shape: {file: bar.json}}]")

    np.testing.assert_array_equal(bar, [[-6, -2], [6, -2], [6, 2], [-6, 2]])


@pytest.mark.parametrize(
    ("stages", "words"),
    [
        ("[{over_s: 5.0}]", "stages[0]: a stage without a shape; give shape, split, join"),
        ("[{join: true}]", "stages[0]: nothing to join: no stage before it has split the shape"),
        ("[{split: {}, join: true}]", "stages[0]: split and join are both given; make them two stages"),
        ("[{scale: 1.1}, {scale: 1.1, split: {}}]", "stages[1]: split and translate_m, scale or rotate_deg are both"),
        ("[{scale: 1.1, at_s: 5.0, hold_s: 1.0}]", "stages[0]: at_s and hold_s are both given; remove one of them"),
        ("[{shape: {name: hw_2_square}, rotate_deg: 90}]", "stages[0]: rotate_deg beside shape is the turn on the way"),
        (
            "[{scale: 1.1, at_s: 500.0}]",
            "stages[0]: it cannot have been formed for success.hold_s before 503 s, and the",
        ),
        (
            "[{scale: 1.1, at_s: 100, over_s: 46}]",
            "before 151 s, and the time limit is 150 s; order it sooner, shorten",
        ),
        (
            "[{scale: 1.1, over_s: 70, hold_s: 0}, {scale: 0.9, over_s: 71, hold_s: 5}]",
            "stages[1]: it cannot have been",
        ),
        ("[{scale: 1.1, at_s: 50.0}, {scale: 1.1, at_s: 40.0}]", "stages[1]: at_s: 40 s is before a stage before it"),
        (
            "[{shape: {name: hw_2_sqare}}]",
            "stages[0]: shape 'hw_2_sqare' is neither a library shape nor a file; did you mean 'hw_2_square'?",
        ),
        ("[{scale: 0.2}]", "stages[0]: a shape of 2.56 m2 is too"),
        ("[{translate_m: [17.0, 0.0], over_s: 20.0}]", "vertex (21, -4) is 1 m outside the arena"),
        ("[{shape: {file: none.json}}]", "none.json: no such file"),
        ("[{overs: 5.0}]", "stages[0].overs: unknown key; did you mean 'over_s'?"),
    ],
)
def test_a_stage_that_cannot_be_is_named_before_anything_starts(stages: str, words: str, tmp_path: Path) -> None:
    message = refusal(tmp_path, stages)

    assert words in message
    assert message.startswith(str(tmp_path / "moving.yaml"))


def test_fractals_refuse_to_move_and_the_stage_is_named(tmp_path: Path) -> None:
    message = refusal(tmp_path, f"[{MORPH}]", method="fractals")

    assert message.endswith(
        "stages[0]: partition method fractals is not applicable to moving shapes; use bubble-packing or voronoi"
    )


def test_a_shape_that_would_pass_over_an_obstacle_is_refused(tmp_path: Path) -> None:
    wall = "map.obstacles=[{name: post, vertices_m: [[7, -1], [8, -1], [8, 1], [7, 1]]}]"

    message = refusal(tmp_path, "[{translate_m: [14.0, 0.0], over_s: 60.0}]", wall)

    assert "stages[0]: after " in message
    assert "% of the way: obstacle 1 at (7.5, " in message


def test_the_mission_computer_is_told_the_stages(tmp_path: Path) -> None:
    scenario: Scenario = moving_scenario(tmp_path, f"[{MORPH}]")

    with InProcessEngine(ScenarioActors(scenario)) as engine:
        record = next(engine.ticks())

    assert record.mission is not None
    assert (record.mission.stage, record.mission.stages_left) == (0, 1)


def test_a_stage_from_the_command_line_is_blamed_on_its_option(tmp_path: Path) -> None:
    message = refusal(tmp_path, f"[{MORPH}]", "stages=[{scale: 1.1}, {translate_m: [17.0, 0.0]}]")

    assert message.startswith("--set stages[1]: 'shape': vertex ")
