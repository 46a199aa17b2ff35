from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from table_top import AWAY, MARKERS, PINK, STARTS, YAWS, camera, localizer, moved

from studies.camera_cases import Case, LookAlike, arena_markers, before, covers, hard_case, in_view, shot
from studies.camera_cli import TABLE, TUNING_SEEDS, main, parse_arguments
from studies.camera_runs import Run, perform
from studies.camera_scores import Scores, scores_of, target_rows, total
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import FloorMarks
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.config import CameraConfig


def test_robots_of_a_case_never_overlap() -> None:
    rng = np.random.default_rng(0)
    radii = np.array([marker.radius for marker in arena_markers()])

    gaps = []
    for _ in range(50):
        positions = hard_case(arena_markers(), rng).positions
        apart = np.linalg.norm(positions[:, None] - positions[None], axis=2)
        gaps.append((apart - radii[:, None] - radii)[np.triu_indices(5, 1)].min())

    assert min(gaps) >= 0.0
    assert np.mean(np.array(gaps) < 0.0021) > 0.1  # and some touch


def test_cases_show_everything_that_is_hard() -> None:
    rng = np.random.default_rng(1)
    cases = [hard_case(arena_markers(), rng) for _ in range(100)]

    assert any(case.is_half_black for case in cases)
    assert any(case.spots for case in cases)
    assert any(np.abs(case.positions).max() > 10.0 for case in cases)
    assert any(1.0 < np.abs(case.positions).max() < 10.0 for case in cases)


def test_in_view_is_whose_whole_cover_shows() -> None:
    positions = STARTS.copy()
    positions[1], positions[2] = (-1.4, 0.0), (30.0, 30.0)
    case = Case(positions, YAWS, (), is_half_black=False)

    assert in_view(case, MARKERS, camera().optics).tolist() == [True, False, False, True, True]
    dark = replace(case, is_half_black=True)
    assert in_view(dark, MARKERS, camera().optics).tolist() == [False, False, False, False, True]


def test_scores_of_two_runs_add_up() -> None:
    one = Scores(
        images=2, in_view=10, found=9, square_sum_m2=9e-6, max_m=0.002, missed={"cut off": 1}, cost_ms=(4, 9, 10)
    )
    other = Scores(images=1, in_view=5, found=5, false=1, max_m=0.001, missed={"cut off": 2}, cost_ms=(6, 7, 30))

    both = total([one, other])

    assert (both.images, both.in_view, both.found, both.false) == (3, 15, 14, 1)
    assert both.max_m == 0.002
    assert both.rms_m == pytest.approx(math.sqrt(9e-6 / 14))
    assert both.missed == {"cut off": 3}
    assert both.cost_ms == (5.0, 9, 30)
    assert scores_of(both.as_record()) == both


def test_targets_are_met_by_good_scores_only() -> None:
    good = Scores(images=10_000, in_view=1000, found=1000, cost_ms=(4.0, 5.0, 14.0))
    bad = Scores(images=1, in_view=1000, found=998, false=1, square_sum_m2=0.02, max_m=0.013, square_sum_rad2=2.0,
                 cost_ms=(16.0, 20.0, 30.0))  # fmt: skip

    assert [row[3] for row in target_rows(good)] == ["yes"] * 8
    assert [row[3] for row in target_rows(bad)] == ["NO"] * 8


def test_no_false_identity_in_few_images_proves_nothing() -> None:
    few = Scores(images=9_999, in_view=1000, found=1000, cost_ms=(4.0, 5.0, 6.0))

    assert target_rows(few)[-1] == ("false identities", "0 of >= 10,000", "0 of 9,999", "too few images")


def test_one_slow_image_misses_the_target_for_the_slowest_only() -> None:
    slow = Scores(images=10_000, in_view=1000, found=1000, cost_ms=(4.0, 5.0, 16.0))

    assert [row[0] for row in target_rows(slow) if row[3] != "yes"] == ["processor time of an image, maximum"]


def test_look_alikes_appear_with_and_without_their_robots_and_touch_nobody() -> None:
    rng, markers = np.random.default_rng(2), arena_markers()
    radii = np.array([marker.radius for marker in markers])
    cases = [case for case in (hard_case(markers, rng) for _ in range(200)) if case.twin is not None]

    alone = 0
    for case in cases:
        assert case.twin is not None
        earlier = before(case)
        assert earlier is not None
        assert earlier.twin is None
        assert (np.hypot(*(earlier.positions - case.twin.position).T) >= radii + radii[case.twin.row]).all()
        alone += bool(np.abs(case.positions[case.twin.row]).max() > 10.0)
        others = np.arange(len(markers)) != case.twin.row
        assert_array_equal(earlier.positions[others], case.positions[others])
    assert 5 < alone < len(cases) - 5


@pytest.mark.parametrize("is_alone", [False, True])
def test_a_look_alike_is_a_false_identity_without_tracks_only(is_alone: bool) -> None:
    twin = LookAlike(PINK, np.array([0.0, -0.1]), 1.0, STARTS)
    shown = moved(PINK, AWAY) if is_alone else STARTS
    case = Case(shown, YAWS, (), is_half_black=False, twin=twin)
    eye = OverheadCamera(CameraConfig(is_on=True), covers(), FloorMarks(), 5)
    earlier = before(case)
    assert earlier is not None

    fresh, watching = localizer(), localizer()
    untracked = fresh.locate(shot(eye, 1, 0.1, case), eye.info)
    watching.locate(shot(eye, 0, 0.0, earlier), eye.info)
    tracked = watching.locate(shot(eye, 1, 0.1, case), eye.info)

    places = [
        [fix.position.round(2).tolist() for fix in each.fixes if fix.robot == PINK] for each in (untracked, tracked)
    ]
    assert places == ([[[0.0, -0.1]], []] if is_alone else [[], [STARTS[PINK].tolist()]])


def test_a_run_is_repeatable_and_accounts_for_every_robot() -> None:
    first, again = perform(Run(3, 3)), perform(Run(3, 3))

    assert replace(first, cost_ms=(0.0, 0.0, 0.0)) == replace(again, cost_ms=(0.0, 0.0, 0.0))
    assert first.in_view + first.beyond_view == 15
    assert first.found + sum(first.missed.values()) == first.in_view
    assert first.found > 5
    assert first.max_m < 0.012


def test_the_study_begins_after_the_seeds_for_tuning() -> None:
    arguments = parse_arguments([])

    assert sum(run.images for run in arguments.runs) == 10_000
    assert min(run.seed for run in arguments.runs) == TUNING_SEEDS


def test_the_command_writes_a_table_and_goes_on_where_it_was(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["--seeds", "1", "--images", "1", "--workers", "1", "--out", str(tmp_path)]

    assert main(command) == 0
    table = (tmp_path / TABLE).read_text(encoding="utf-8")
    assert main(command) == 0

    assert "1 images of 1 cameras" in table
    assert "1 of 1 runs are done" in capsys.readouterr().err


def test_bad_input_is_refused_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--images", "0"]) == 2
    assert capsys.readouterr().err.startswith("error: --images")
    with pytest.raises(ConfigError, match="first-seed"):
        parse_arguments(["--first-seed", str(2**32 - 1)])
