from __future__ import annotations

from pathlib import Path

import pytest
from robustness_report import IDEAL, REFERENCE, Report

WHOLE: dict[str, object] = {
    "engine": "inprocess",
    "physics": "massdamper",
    "scenario": "any",
    "achieved": True,
    "reason": "",
    "settling_time_s": 100.0,
    "displacement_ratio": 1.0,
    "collisions": 0,
    "min_clearance_m": 0.1,
    "radio_neighborhood_peak_bps": 150_000.0,
    "localization_rmse_m": 0.09,
    "longest_split_s": None,
    "agreed_after_s": None,
    "busy_with_computer": None,
    "busy_without_computer": None,
}


def one(experiment: str, variant: str, seed: int = 1, **changes: object) -> dict[str, object]:
    return {**WHOLE, "experiment": experiment, "variant": variant, "seed": seed, **changes}


def loss(slow: float, ideal: float = 100.0) -> list[dict[str, object]]:
    """Return results in which 30 % of the frames are lost, and two seeds take `slow` s, the others 100 s."""
    return [
        one("loss", variant, seed, settling_time_s=settling)
        for variant, settling in ((IDEAL, ideal), (REFERENCE, 100.0), ("loss 30 %, delay", slow))
        for seed in (1, 2)
    ]


def split(**changes: object) -> list[dict[str, object]]:
    return [
        one("split", "split and merge", 1, agreed_after_s=8.0),
        one("split", "split and merge", 2, **{"agreed_after_s": 9.0, **changes}),
    ]


def test_good_runs_miss_no_target(capsys: pytest.CaptureFixture[str]) -> None:
    assert Report([*loss(129.0), *split(), one("kills", "20 % killed")]).print()
    assert "missed" not in capsys.readouterr().out


def test_settling_that_takes_longer_than_the_target_ratio_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert not Report(loss(131.0)).print()
    assert f"- missed: loss 30 %, delay: settling is 1.310 x that of '{REFERENCE}', at most 1.3" in (
        capsys.readouterr().out
    )


def test_one_slow_seed_does_not_miss_a_target_of_the_mean() -> None:
    runs = loss(100.0)
    runs[-1]["settling_time_s"] = 150.0

    assert list(Report(runs).missed()) == []


def test_the_ratio_is_judged_against_the_same_delay_and_shown_against_both(capsys: pytest.CaptureFixture[str]) -> None:
    assert Report(loss(125.0, ideal=50.0)).print()

    (row,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("| loss 30 %"))
    assert row.endswith("| 2.500, worst 2.500 | 1.250, worst 1.250 | 1.3 |")


def test_a_ratio_without_its_reference_is_no_success() -> None:
    runs = [run for run in loss(100.0) if run["variant"] != REFERENCE]

    assert list(Report(runs).missed()) == [
        f"loss 30 %, delay: settling is unknown x that of '{REFERENCE}', at most 1.3"
    ]


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"agreed_after_s": 10.5}, "agreed 10.5 s after the merge, at most 10 s"),
        ({"agreed_after_s": None}, "never agreed after a merge, at most 10 s"),
        ({"radio_neighborhood_peak_bps": 250_000.0}, "taken by 250.0 kbit/s, less than 250 kbit/s"),
        ({"achieved": False, "reason": "time is over"}, "not achieved (time is over)"),
        ({"collisions": 2}, "2 collisions"),
    ],
)
def test_each_seed_must_meet_what_is_asked_of_single_runs(
    changes: dict[str, object], named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert not Report(split(**changes)).print()

    (line,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("- missed"))
    assert line.startswith("- missed: split and merge, seed 2: ")
    assert named in line


def test_the_table_says_how_well_robots_were_localized(capsys: pytest.CaptureFixture[str]) -> None:
    Report([one("kills", "20 % killed", 1), one("kills", "20 % killed", 2, localization_rmse_m=0.31)]).print()

    head, _, row = (line for line in capsys.readouterr().out.splitlines() if line.startswith("|"))
    column = head.split(" | ").index("localization rms, mean / worst [m]")
    assert row.split(" | ")[column] == "0.20 / 0.31"


def test_the_figure_has_a_panel_for_what_was_run_and_is_not_drawn_of_nothing(tmp_path: Path) -> None:
    Report([]).draw(tmp_path / "none.png")
    Report([*loss(120.0), *split()]).draw(tmp_path / "some.png")

    assert not (tmp_path / "none.png").exists()
    assert (tmp_path / "some.png").read_bytes().startswith(b"\x89PNG")
