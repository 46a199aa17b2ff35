"""The report: one HTML file with everything in it, which needs no network and no server."""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from reports.replay_data import replay_data
from reports.run_record import RunRecord
from reports.series import Chart, charts
from reports.views import View, view_of

ASSETS = Path(__file__).parent / "page"
SCRIPTS = ("vendor/uPlot.iife.min.js", "packed.js", "timeline.js", "marks.js", "charts.js", "player.js")
STYLES = ("vendor/uPlot.min.css", "report.css")
PLACE = re.compile(r"\{\{(\w+)\}\}")  # in the template
CHART_POINTS_MAX = 1000
UNITS = {"_mps": "m/s", "_m_s": "m/s", "_bps": "bit/s", "_rad": "rad", "_deg": "deg", "_m": "m", "_s": "s"}
"""Endings of the names of metrics, the longer ones first, with their units."""


def report_page(record: RunRecord) -> bytes:
    """Return the report of a run, as UTF-8.

    Everything that the page runs and shows is in it; its content policy forbids it to load anything else.
    """
    view = view_of(record)
    metrics = record.metrics
    data = _page_data(record, view)
    parts = {
        "title": html.escape(f"{metrics.get('scenario', 'run')}, seed {metrics.get('seed', '?')}"),
        "subtitle": html.escape(_subtitle(record)),
        "verdict": "achieved" if metrics.get("achieved") else "not-achieved",
        "verdict_text": "achieved" if metrics.get("achieved") else "not achieved",
        "reason": html.escape(str(metrics.get("reason", ""))),
        "metrics": _metrics_table(record),
        "scenario": html.escape(record.scenario),
        "styles": "\n".join(_asset(name) for name in STYLES),
        "scripts": "\n".join(_asset(name) for name in _script_names(view)),
        "thinning": html.escape(_thinning(data["replay"]["steps"])),
        "data": _embedded(data),
    }
    return PLACE.sub(lambda place: parts[place[1]], _asset("report.html")).encode("utf-8")


def _script_names(view: View) -> tuple[str, ...]:
    return (*SCRIPTS, f"{view.name}_view.js", "main.js")


def _asset(name: str) -> str:
    return (ASSETS / name).read_text(encoding="utf-8")


def _page_data(record: RunRecord, view: View) -> dict[str, Any]:
    return {
        "view": view.name,
        "extra": view.data(record),
        "replay": replay_data(record),
        "charts": [_chart_data(chart) for chart in charts(record)],
    }


def _embedded(data: dict[str, Any]) -> str:
    """Return JSON that cannot end the script element that holds it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")


def _chart_data(chart: Chart) -> dict[str, Any]:
    rows = np.unique(np.linspace(0, len(chart.times) - 1, min(len(chart.times), CHART_POINTS_MAX)).round().astype(int))
    return {
        "name": chart.name,
        "title": f"{chart.title} [{chart.unit}]" if chart.unit else chart.title,
        "times": [round(float(time), 3) for time in chart.times[rows]],
        "lines": [{"label": line.label, "values": [_short(v) for v in line.values[rows]]} for line in chart.lines],
    }


def _short(value: float) -> float | None:
    return float(f"{value:.4g}") if math.isfinite(value) else None


def _subtitle(record: RunRecord) -> str:
    metrics = record.metrics
    named = [str(metrics[key]) for key in ("family", "method") if metrics.get(key)]
    parts = [*named, f"{len(record.robots)} robots"]
    parts += [f"{metrics['sim_time_s']:g} s"] if metrics.get("sim_time_s") is not None else []
    parts += [" on ".join(str(metrics[key]) for key in ("physics", "engine") if metrics.get(key))]
    return " · ".join(part for part in parts if part)


def _thinning(steps: Mapping[str, int]) -> str:
    """Return what is not shown tick by tick, in a line; nothing where all is."""
    if not steps:
        return ""
    told = ", ".join(f"{name} every {step} ticks" for name, step in steps.items())
    return f"A long run, shown coarser than it was, so that this file stays small: {told}. trajectories.npz has it all."


def _metrics_table(record: RunRecord) -> str:
    rows = [
        f"<tr><th scope='row'>{html.escape(name)}</th><td>{html.escape(_text(value))}</td>"
        f"<td>{_unit(name) if value is not None else ''}</td></tr>"
        for name, value in record.metrics.items()
    ]
    return "\n".join(rows)


def _text(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, list):
        return ", ".join(_text(part) for part in value)
    return str(value)


def _unit(name: str) -> str:
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")
