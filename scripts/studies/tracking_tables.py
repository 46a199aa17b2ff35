"""The numbers of the tracking study as tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from studies.tracking_curves import CurveKind
from studies.tracking_trial import Scores
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import ControllerKind

LABELS = {
    ControllerKind.LADRC: "LADRC",
    ControllerKind.LADRC_PAPER: "LADRC, gains of the paper",
    ControllerKind.PID: "PID, optimized",
    ControllerKind.PID_ZN: "PID, Ziegler-Nichols",
}
Results = Mapping[tuple[CurveKind, ControllerKind], Scores]

HEADER = (
    "curve",
    "controller",
    "position MAE [mm]",
    "heading MAE [deg]",
    "with approach [mm]",
    "[deg]",
    "convergence [s]",
    "thrust energy [N^2 s]",
)
COMPARISON_HEADER = ("curve", "LADRC against", "position MAE", "heading MAE", "convergence", "thrust energy")


@dataclass(frozen=True, slots=True)
class _Column:
    """A number of a trial and how it is written."""

    name: str
    scale: float
    digits: int

    def values(self, scores: Scores) -> FloatArray:
        return self.scale * np.asarray(getattr(scores, self.name))

    def text(self, scores: Scores) -> str:
        values = self.values(scores)
        return f"{values.mean():.{self.digits}f} ± {values.std():.{self.digits}f}"


_COLUMNS = (
    _Column("position_m", 1000.0, 2),
    _Column("heading_rad", float(np.degrees(1.0)), 3),
    _Column("position_all_m", 1000.0, 1),
    _Column("heading_all_rad", float(np.degrees(1.0)), 2),
    _Column("convergence_s", 1.0, 2),
    _Column("energy_n2s", 1.0, 1),
)
_COMPARED = (_COLUMNS[0], _COLUMNS[1], _COLUMNS[4], _COLUMNS[5])


def score_rows(results: Results) -> list[tuple[str, ...]]:
    """Return a row per curve and controller: mean and standard deviation over seeds."""
    return [
        (curve.value, LABELS[controller], *(column.text(scores) for column in _COLUMNS))
        for (curve, controller), scores in results.items()
    ]


def comparison_rows(results: Results) -> list[tuple[str, ...]]:
    """Return how much LADRC differs from each other controller, in percent of its mean."""
    rows = []
    for (curve, controller), scores in results.items():
        if controller is ControllerKind.LADRC or (curve, ControllerKind.LADRC) not in results:
            continue
        own = results[curve, ControllerKind.LADRC]
        changes = [column.values(own).mean() / column.values(scores).mean() - 1.0 for column in _COMPARED]
        rows.append((curve.value, LABELS[controller], *(f"{100.0 * change:+.1f} %" for change in changes)))
    return rows


def as_markdown(results: Results, seeds: int, body: float = 1.0, weather: float = 1.0) -> str:
    """Return both tables, and what they hold; `body` and `weather` are relative to what the gains were made for."""
    changed = f" Body times {body:g}, weather times {weather:g}." if (body, weather) != (1.0, 1.0) else ""
    parts = [
        f"One boat, {seeds} seeds of wind, waves and noise: mean ± standard deviation. MAE: mean absolute error of one"
        f" round, after the approach from the middle of the pool.{changed}",
        _table(HEADER, score_rows(results)),
        _table(COMPARISON_HEADER, comparison_rows(results)),
    ]
    return "\n\n".join(parts) + "\n"


def as_csv(results: Results) -> str:
    """Return a line per curve, controller and seed."""
    names = [column.name for column in _COLUMNS]
    lines = [",".join(["curve", "controller", "row", *names])]
    for (curve, controller), scores in results.items():
        table = np.column_stack([getattr(scores, name) for name in names])
        lines += [
            ",".join([curve.value, controller.value, str(row), *(f"{number:.6g}" for number in numbers)])
            for row, numbers in enumerate(table)
        ]
    return "\n".join(lines) + "\n"


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [header, tuple("---" for _ in header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
