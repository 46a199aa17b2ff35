"""How the benchmarks print: rows of Markdown tables."""

from __future__ import annotations

from collections.abc import Sequence


def print_row(cells: Sequence[str]) -> None:
    """Print a row, at once."""
    print(f"| {' | '.join(cells)} |", flush=True)


def print_head(names: Sequence[str]) -> None:
    """Print the names of the columns, and the line below."""
    print_row(names)
    print_row(["---"] * len(names))


def number(value: float | None, digits: int = 1) -> str:
    """Return a number as a cell, a dash for what is not known."""
    return "-" if value is None else f"{value:.{digits}f}"
