from __future__ import annotations

import csv
import io

import pytest

from studies.lps_cells import BASE_PERIOD_S, CONTROL_RATE, Cell, Design, Experiment, Run, Trial, cells
from studies.lps_figure import study_figure
from studies.lps_summary import Summary, targets
from studies.lps_tables import as_csv, as_markdown, target_rows
from swarm_agent.localization.config import LpsMode

LITERAL = Cell(experiment=Experiment.FORMATION, mode=LpsMode.LITERAL, period_s=BASE_PERIOD_S)
BEST = Cell(experiment=Experiment.FORMATION, mode=LpsMode.COOPERATIVE, period_s=CONTROL_RATE)
FLIGHT = Cell(experiment=Experiment.MISSION, mode=LpsMode.COOPERATIVE, period_s=CONTROL_RATE)


def summary_of(*results: tuple[Cell, int, dict[str, object]]) -> Summary:
    runs = [Run(cell, seed, Trial()) for cell, seed, _ in results]
    return Summary(runs, {run.key: record for run, (_, _, record) in zip(runs, results, strict=True)})


def test_a_statistic_is_the_mean_over_the_seeds_and_the_worst_of_them() -> None:
    summary = summary_of(
        (LITERAL, 1, {"rms_m": 1.0, "nees_share": 0.9}),
        (LITERAL, 2, {"rms_m": 2.0, "nees_share": 0.8}),
        (LITERAL, 3, {"rms_m": None, "nees_share": None}),
    )

    rms, share = summary.statistic(LITERAL, "rms_m"), summary.statistic(LITERAL, "nees_share")

    assert rms is not None
    assert share is not None
    assert (rms.mean, rms.best, rms.worst, rms.seeds) == (1.5, 1.0, 2.0, 2)
    assert (share.mean, share.worst) == (pytest.approx(0.85), 0.8)
    assert summary.seeds(LITERAL) == 3
    assert summary.statistic(BEST, "rms_m") is None


def test_the_order_in_which_runs_finish_does_not_change_a_digit() -> None:
    results = [(LITERAL, seed, {"rms_m": 1.0 / seed}) for seed in range(1, 20)]

    assert summary_of(*results).statistic(LITERAL, "rms_m") == summary_of(*results[::-1]).statistic(LITERAL, "rms_m")


def test_targets_speak_of_cells_that_the_default_study_runs() -> None:
    assert {target.cell for target in targets()} <= set(cells(Design()))


def test_an_error_must_not_exceed_its_target_and_a_share_must_reach_it() -> None:
    rows = target_rows(Trial(), summary_of((BEST, 1, {"rms_m": 0.31, "p99_m": 0.65, "max_m": 1.0, "nees_share": 0.89})))

    assert [(row[1], row[2], row[-1].startswith("yes")) for row in rows] == [
        ("rms [m]", "<= 0.3", False),
        ("p99 [m]", "<= 0.65", True),
        ("max [m]", "<= 1.2", True),
        ("NEES in band", ">= 0.9", False),
    ]


def test_a_verdict_on_few_seeds_says_so() -> None:
    few = target_rows(Trial(), summary_of((FLIGHT, 1, {"rms_m": 0.2})))
    many = target_rows(Trial(), summary_of(*((FLIGHT, seed, {"rms_m": 0.2}) for seed in range(30))))

    assert few[0][-1] == "yes (of 30 seeds)"
    assert many[0][-1] == "yes"


def test_other_swarms_than_that_of_the_thesis_have_no_targets() -> None:
    assert target_rows(Trial(robots=6), summary_of((FLIGHT, 1, {"rms_m": 0.2}))) == []


def test_the_claims_of_the_thesis_stand_beside_the_literal_mode() -> None:
    text = as_markdown(Design(), Trial(), 1, summary_of((LITERAL, 1, {"rms_m": 1.25, "max_m": 3.5})))

    (row,) = (line for line in text.splitlines() if line.startswith("| 3 s |"))
    assert [cell.strip() for cell in row.strip("|").split("|")][:4] == ["3 s", "3", "1.3 / 4", "1.250 (1.250)"]


def test_missions_report_what_became_of_them() -> None:
    record = {"rms_m": 0.2, "achieved": True, "collisions": 0, "displacement_ratio": 1.02}
    lost = {"rms_m": 0.2, "achieved": False, "collisions": 3, "displacement_ratio": None}

    text = as_markdown(Design(), Trial(), 2, summary_of((FLIGHT, 1, record), (FLIGHT, 2, lost)))

    assert "| 1 of 2 | 3 | 1.020 (1.020) |" in text


def test_a_table_has_only_cells_with_results() -> None:
    text = as_markdown(Design(), Trial(), 1, summary_of((BEST, 1, {"rms_m": 0.2})))
    rows = list(csv.DictReader(io.StringIO(as_csv(cells(Design()), summary_of((BEST, 1, {"rms_m": 0.2}))))))

    assert "literal" not in text
    assert [(row["mode"], row["period_s"], row["rms_m_mean"], row["p99_m_mean"]) for row in rows] == [
        ("cooperative", "0.0", "0.2", "")
    ]


def test_a_warning_about_the_results_stands_above_the_tables() -> None:
    text = as_markdown(Design(), Trial(), 1, summary_of((BEST, 1, {"rms_m": 0.2})), "warning: made by other code")

    assert 0 < text.index("**warning: made by other code**") < text.index("## ")
    assert "warning" not in as_markdown(Design(), Trial(), 1, summary_of((BEST, 1, {"rms_m": 0.2})))


def test_the_figure_has_a_panel_per_sweep_with_results_and_none_without() -> None:
    one = study_figure(Design(), Trial(), summary_of((BEST, 1, {"rms_m": 0.2, "max_m": 1.0})))

    assert study_figure(Design(), Trial(), summary_of()) is None
    assert one is not None
    assert one.startswith(b"\x89PNG")
