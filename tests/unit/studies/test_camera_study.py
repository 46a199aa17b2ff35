from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from table_top import MARKERS, STARTS, YAWS, camera

from studies.camera_cases import Case, arena_markers, hard_case, in_view
from studies.camera_cli import TABLE, TUNING_SEEDS, main, parse_arguments
from studies.camera_runs import Run, perform
from studies.camera_scores import Scores, scores_of, target_rows, total
from swarm_msgs_py.errors import ConfigError


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
    one = Scores(images=2, in_view=10, found=9, square_sum_m2=9e-6, max_m=0.002, missed={"cut off": 1}, cost_ms=(4, 9))
    other = Scores(images=1, in_view=5, found=5, false=1, max_m=0.001, missed={"cut off": 2}, cost_ms=(6, 7))

    both = total([one, other])

    assert (both.images, both.in_view, both.found, both.false) == (3, 15, 14, 1)
    assert both.max_m == 0.002
    assert both.rms_m == pytest.approx(math.sqrt(9e-6 / 14))
    assert both.missed == {"cut off": 3}
    assert both.cost_ms == (5.0, 9)
    assert scores_of(both.as_record()) == both


def test_targets_are_met_by_good_scores_only() -> None:
    good = Scores(images=1, in_view=1000, found=1000, cost_ms=(4.0, 5.0))
    bad = Scores(images=1, in_view=1000, found=998, false=1, square_sum_m2=0.02, max_m=0.013, square_sum_rad2=2.0,
                 cost_ms=(16.0, 20.0))  # fmt: skip

    assert [row[3] for row in target_rows(good)] == ["yes"] * 6
    assert [row[3] for row in target_rows(bad)] == ["NO"] * 6


def test_a_run_is_repeatable_and_accounts_for_every_robot() -> None:
    first, again = perform(Run(3, 3)), perform(Run(3, 3))

    assert replace(first, cost_ms=(0.0, 0.0)) == replace(again, cost_ms=(0.0, 0.0))
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
