"""A comparison as Markdown and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Sequence
from itertools import groupby

from batches.cells import Cell
from batches.comparison import Comparison, Place
from batches.controls import controls
from batches.estimates import LEVEL, Estimate
from batches.quantities import OF_SETTLED, QUANTITIES, SHARE, Quantity

ALL = (SHARE, *QUANTITIES)
NOTHING = "-"
CSV_HEADER = (
    *("scenario", "shape", "method", "objective", "quantity", "runs", "mean", "deviation", "low", "high", "worst"),
    *("pairs", "difference", "difference_low", "difference_high"),
)
HEADER = ("quantity", "method", "mean", "deviation", f"{LEVEL:.0%} interval", "worst", "runs", "difference", "pairs")
NAMING = ("scenario", "shape", "method")
SHORT = (SHARE, *QUANTITIES[:5])
"""What fits a terminal."""
SHORT_HEADER = (
    *(*NAMING, "runs"),
    *(f"{quantity.label} (settled/runs)" if quantity.name in OF_SETTLED else quantity.label for quantity in SHORT),
)
COVERED = (
    "What the intervals cover: random starts only. `bubble-packing` and `voronoi` place the goals of a shape in "
    "one way, whatever the seed, so that their mesh quantities differ from run to run only by where robots come "
    "from and park; the intervals of these say how well the mesh of this one partition is known, not how good the "
    "method is in another shape or orientation. `fractals` are drawn anew with each seed, forces end elsewhere "
    "from each start. Runs made with `--turns` have the shape in an orientation drawn from the seed, and their "
    "intervals cover orientations too. The lattice has no interval: its few orientations are no sample. Settling "
    "is known of the runs that settled only; compare methods by it where they settle alike often."
)


def as_markdown(comparison: Comparison, notes: Sequence[str] = ()) -> str:
    """Return one table per scenario and shape, under what there is to know of the numbers.

    Parameters
    ----------
    comparison : Comparison
    notes : sequence of str
        Warnings, each a line.
    """
    parts = [
        "# Comparison of methods",
        f"Each mean is over runs with different random starts and has an interval of {LEVEL:.0%} confidence: Student's "
        "t for means, Wilson's score for the achieved share. *runs*: those that have the number; a run that never "
        "settled has no settling time. *difference*: to the first method, run by run on equal starts, with Student's t "
        "interval of the paired differences. In parentheses: what the mesh of robots would be that stood on a "
        "hexagonal lattice cut out by the shape, and at random points of it.",
        COVERED,
        *(f"**{note}**" for note in notes),
        *(_section(comparison, place) for place in comparison.places),
    ]
    return "\n\n".join(parts) + "\n"


def as_csv(comparison: Comparison) -> str:
    """Return one line per cell and quantity; empty where there is no number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CSV_HEADER)
    for cell, quantity, found, difference in _numbers(comparison):
        numbers = [found.mean, found.deviation, found.low, found.high, None if quantity is SHARE else found.worst]
        paired = [difference.mean, difference.low, difference.high] if difference else [None, None, None]
        writer.writerow(
            [
                *(*cell.place, cell.method, cell.objective, quantity.name, found.count),
                *map(_exact, numbers),
                difference.count if difference else "",
                *map(_exact, paired),
            ]
        )
    for place in comparison.places:
        for quantity in ALL:
            for name, found in _controls(comparison, place, quantity):
                numbers = [found.mean, found.deviation, found.low, found.high, found.worst]
                writer.writerow([*place, name, "", quantity.name, found.count, *map(_exact, numbers), "", "", "", ""])
    return text.getvalue()


def short_rows(comparison: Comparison) -> list[list[str]]:
    """Return one row per cell with means only, as `SHORT_HEADER` says, so that it fits a terminal."""
    rows = []
    for place in comparison.places:
        for cell in comparison.at(place):
            means = [_short(comparison, cell, quantity) for quantity in SHORT]
            rows.append([*place, cell.variant, str(comparison.count(cell)), *means])
    return rows


def _short(comparison: Comparison, cell: Cell, quantity: Quantity) -> str:
    found = comparison.estimate(cell, quantity)
    mean = f"{found.mean:.4g}" if found else NOTHING
    return f"{mean} ({comparison.settled(cell)})" if quantity.name in OF_SETTLED else mean


def _section(comparison: Comparison, place: Place) -> str:
    rows = []
    for quantity, group in groupby(_numbers(comparison, place), key=lambda entry: entry[1]):
        of_methods = [_row(cell.variant, quantity, found, difference) for cell, _, found, difference in group]
        of_controls = [_row(name, quantity, found, None) for name, found in _controls(comparison, place, quantity)]
        labels = [quantity.label, *[""] * (len(of_methods) + len(of_controls) - 1)]
        rows += [[label, *row] for label, row in zip(labels, of_methods + of_controls, strict=True)]
    lines = [HEADER, ["---"] * len(HEADER), *rows]
    return "\n".join([f"## {place[0]}, {place[1]}", "", *(f"| {' | '.join(cells)} |" for cells in lines)])


Entry = tuple[Cell, Quantity, Estimate, Estimate | None]


def _numbers(comparison: Comparison, only: Place | None = None) -> Iterator[Entry]:
    """Yield what there is, by place, then by quantity, then by variant."""
    for place in comparison.places if only is None else (only,):
        for quantity in ALL:
            for cell in comparison.at(place):
                found = comparison.estimate(cell, quantity)
                if found is not None:
                    yield cell, quantity, found, comparison.difference(cell, quantity)


def _controls(comparison: Comparison, place: Place, quantity: Quantity) -> Iterator[tuple[str, Estimate]]:
    """Yield name and mean of each control that has a number; none where no robot stands in the shape by itself."""
    for control in controls(comparison.at(place)[0]):
        found = control.estimate(quantity)
        if found is not None:
            yield control.name, found


def _row(name: str, quantity: Quantity, found: Estimate, difference: Estimate | None) -> list[str]:
    return [
        name,
        f"{found.mean:.4g}",
        NOTHING if found.deviation is None else f"{found.deviation:.3g}",
        _interval(found),
        NOTHING if quantity is SHARE else f"{found.worst:.4g}",
        str(found.count),
        f"{difference.mean:+.3g} {_interval(difference)}" if difference else NOTHING,
        str(difference.count) if difference else NOTHING,
    ]


def _interval(found: Estimate) -> str:
    return NOTHING if found.low is None or found.high is None else f"[{found.low:.4g}, {found.high:.4g}]"


def _exact(number: float | None) -> str:
    return "" if number is None else f"{number:.8g}"
