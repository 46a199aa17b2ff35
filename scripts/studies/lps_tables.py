"""The numbers of the study as Markdown and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import fields

from studies.lps_cells import (
    BASE_SHARE,
    BASE_SIGMA_M,
    Cell,
    Design,
    Experiment,
    Motion,
    SweepKind,
    Trial,
    mission_cells,
    sweeps,
)
from studies.lps_scores import Scores
from studies.lps_summary import SEEDS_FOR_A_CLAIM, SMALLER_IS_WORSE, THESIS, Statistic, Summary, Target, targets
from swarm_agent.localization.config import LpsMode

MODE_LABELS = {
    LpsMode.LITERAL: "literal",
    LpsMode.FIXES: "fixes",
    LpsMode.RANGE_EKF: "range EKF",
    LpsMode.COOPERATIVE: "cooperative",
}
NAMES = {
    "rms_m": "rms [m]",
    "p99_m": "p99 [m]",
    "max_m": "max [m]",
    "lost_share": "lost",
    "lost_rms_m": "rms lost [m]",
    "nees_share": "NEES in band",
    "nees_mean": "mean NEES",
    "achieved": "achieved",
    "collisions": "collisions",
    "displacement_ratio": "displacement / bound",
    "settling_ratio": "settling / bottleneck",
}
ERRORS = ("rms_m", "p99_m", "max_m", "lost_share", "lost_rms_m", "nees_share", "nees_mean")
MISSION = (
    "rms_m",
    "p99_m",
    "max_m",
    "nees_share",
    "nees_mean",
    "achieved",
    "collisions",
    "displacement_ratio",
    "settling_ratio",
)
TITLES = {
    SweepKind.PERIOD: f"Error against localization period ({BASE_SHARE:.0%} beacons, noise {BASE_SIGMA_M:g} m)",
    SweepKind.SHARE: f"Error against beacon share (noise {BASE_SIGMA_M:g} m)",
    SweepKind.NOISE: f"Error against noise ({BASE_SHARE:.0%} beacons)",
}

TARGET_HEADER = ["what", "number", "target", "mean", "worst seed", "seeds", "met"]
ROW_HEADER = ["mode", "period", "beacons", "noise [m]", "seeds"]
CELL_HEADER = ["experiment", *ROW_HEADER, *(NAMES[name] for name in ERRORS)]


def period_label(period_s: float) -> str:
    """Return how people call a localization period."""
    return f"{period_s:g} s" if period_s else "control rate"


def as_markdown(design: Design, trial: Trial, seeds: int, summary: Summary, warning: str = "") -> str:
    """Return all tables; each number is the mean over the seeds, and in brackets that of the worst seed.

    A warning about the results stands above them: who reads the tables has not seen the terminal.
    """
    parts = [_heading(design, trial, seeds), *([f"\n**{warning}**"] if warning else [])]
    parts += _section("Targets", TARGET_HEADER, target_rows(trial, summary))
    parts += _thesis(design, summary)
    for sweep in sweeps(design):
        rows = [row for cell in sweep.cells if (row := _row(cell, ERRORS, summary))]
        parts += _section(TITLES[sweep.kind], _header(ERRORS), rows)
    rows = [row for cell in mission_cells(design) if (row := _row(cell, MISSION, summary))]
    parts += _section("In the mission, after 60 s", _header(MISSION), rows)
    return "\n".join(parts) + "\n"


def as_csv(cells: Sequence[Cell], summary: Summary) -> str:
    """Return one line per cell that has results: what it is, then mean and worst of each number."""
    names = [field.name for field in fields(Scores)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    what = ("experiment", "mode", "ranging", "motion", "period_s", "beacon_share", "sigma_m", "seeds")
    writer.writerow([*what, *(f"{name}_{kind}" for name in names for kind in ("mean", "worst"))])
    for cell in cells:
        if cell not in summary:
            continue
        of_cell = (cell.experiment.value, cell.mode.value, cell.ranging.value, cell.motion.value)
        row: list[object] = [*of_cell, cell.period_s, cell.share, cell.sigma_m, summary.seeds(cell)]
        for name in names:
            found = summary.statistic(cell, name)
            row += [f"{found.mean:.6g}", f"{found.worst:.6g}"] if found else ["", ""]
        writer.writerow(row)
    return text.getvalue()


def cell_rows(cells: Sequence[Cell], summary: Summary) -> list[list[str]]:
    """Return one row per cell that has results, as `CELL_HEADER` says; only means, so that it fits a terminal."""
    return [
        [cell.experiment.value, *(value.partition(" (")[0] for value in row)]
        for cell in cells
        if (row := _row(cell, ERRORS, summary))
    ]


def target_rows(trial: Trial, summary: Summary) -> list[list[str]]:
    """Return one row per target of a cell that was measured, as `TARGET_HEADER` says.

    Targets speak of fifty robots; another trial has none.
    """
    if trial != Trial():
        return []
    return [row for target in targets() if (row := _target_row(target, summary))]


def _target_row(target: Target, summary: Summary) -> list[str] | None:
    found = summary.statistic(target.cell, target.name)
    if found is None:
        return None
    sign = ">=" if target.name in SMALLER_IS_WORSE else "<="
    verdict = "yes" if target.is_met_by(found.mean) else "**no**"
    if found.seeds < SEEDS_FOR_A_CLAIM:
        verdict += f" (of {SEEDS_FOR_A_CLAIM} seeds)"
    cell = target.cell
    what = f"{MODE_LABELS[cell.mode]}, {period_label(cell.period_s)}"
    if cell.experiment is Experiment.MISSION:
        what = f"mission, {what}"
    limit = f"{sign} {target.limit:g}"
    return [what, NAMES[target.name], limit, f"{found.mean:.3f}", f"{found.worst:.3f}", str(found.seeds), verdict]


def _heading(design: Design, trial: Trial, seeds: int) -> str:
    shown = f"{trial.robots} robots, errors of those that are no beacons"
    times = f"{trial.warm_up_s:g} to {trial.duration_s:g} s after the start"
    motion = "" if Experiment.FORMATION not in design.experiments else f"; robots {_doing(design)}, {times}"
    return (
        f"# Localization study\n\n{shown}{motion}. Mean over up to {seeds} seeds (in brackets: worst seed). "
        "Robots in a shape that are lost by the rule of their mode (too few beacons, or beacons on a line) are told "
        "apart; in missions everybody counts.\n"
        "NEES in band: share of estimates whose normalized error squared lies in its 95 % band; mean NEES: 2 is ideal."
    )


def _doing(design: Design) -> str:
    return {
        Motion.REST: "rest in the shape",
        Motion.PARKED: "rest in the shape and know it",
        Motion.WANDER: "wander about their places in the shape",
    }[design.motion]


def _thesis(design: Design, summary: Summary) -> list[str]:
    """Return the thesis' study of the period beside ours."""
    header = ["period", "largest error, thesis [m]", "rms / max expected (E12) [m]", "rms [m]", "p99 [m]", "max [m]"]
    rows = []
    for point in THESIS:
        cell = Cell(
            experiment=Experiment.FORMATION, mode=LpsMode.LITERAL, period_s=point.period_s, motion=design.motion
        )
        if cell in summary:
            ours = [_shown("", summary.statistic(cell, name)) for name in ERRORS[:3]]
            expected = f"{point.expected_rms_m:g} / {point.expected_max_m:g}"
            rows.append([f"{point.period_s:g} s", f"{point.claimed_max_m:g}", expected, *ours])
    return _section("The study of the thesis (figures 4.4 to 4.6) beside ours: mode literal", header, rows)


def _header(names: Iterable[str]) -> list[str]:
    return [*ROW_HEADER, *(NAMES[name] for name in names)]


def _row(cell: Cell, names: Iterable[str], summary: Summary) -> list[str] | None:
    if cell not in summary:
        return None
    what = [MODE_LABELS[cell.mode], period_label(cell.period_s), f"{cell.share:.0%}", f"{cell.sigma_m:g}"]
    return [*what, str(summary.seeds(cell)), *(_shown(name, summary.statistic(cell, name)) for name in names)]


def _shown(name: str, found: Statistic | None) -> str:
    if found is None:
        return "-"
    if name == "achieved":
        return f"{found.mean * found.seeds:.0f} of {found.seeds}"
    if name == "lost_share":
        return f"{found.mean:.1%} ({found.worst:.1%})"
    if name == "collisions":
        return f"{found.mean * found.seeds:.0f}"
    return f"{found.mean:.3f} ({found.worst:.3f})"


def _section(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    if not rows:
        return []
    lines = [header, ["---"] * len(header), *rows]
    return [f"\n## {title}\n", *(f"| {' | '.join(cells)} |" for cells in lines)]
