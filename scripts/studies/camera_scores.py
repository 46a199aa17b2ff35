"""What the images of the camera study come to, and whether that is what the project promises."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from studies.campaign import Record

MM = 1e3
TARGET_HEADER = ("quantity", "target", "measured", "met")


@dataclass(frozen=True, slots=True)
class Scores:
    """Counts and sums over images.

    Attributes
    ----------
    images : int
    in_view, found : int
        Robots whose whole cover an image showed, and how many of them had a true fix.
    false : int
        Fixes that are not of the robot that they name.
    beyond_view, found_beyond : int
        Robots that an image showed only in part or not at all, and how many of them had a fix.
    square_sum_m2, max_m : float
        Of the position errors of robots in view [m^2], [m].
    square_sum_rad2, max_rad : float
        Of their heading errors [rad^2], [rad].
    missed, hidden : dict
        Why robots had no fix, in view and not in view: number by reason.
    cost_ms : (float, float)
        Median and 99th percentile of the processor time from an image to its fixes [ms].
    """

    images: int = 0
    in_view: int = 0
    found: int = 0
    false: int = 0
    beyond_view: int = 0
    found_beyond: int = 0
    square_sum_m2: float = 0.0
    max_m: float = 0.0
    square_sum_rad2: float = 0.0
    max_rad: float = 0.0
    missed: dict[str, int] = field(default_factory=dict)
    hidden: dict[str, int] = field(default_factory=dict)
    cost_ms: tuple[float, float] = (0.0, 0.0)

    def as_record(self) -> Record:
        """Return what is kept of a run."""
        return dataclasses.asdict(self)

    @property
    def rms_m(self) -> float:
        """Return the root mean square position error [m]."""
        return math.sqrt(self.square_sum_m2 / max(self.found, 1))

    @property
    def rms_rad(self) -> float:
        """Return the root mean square heading error [rad]."""
        return math.sqrt(self.square_sum_rad2 / max(self.found, 1))


def scores_of(record: Record) -> Scores:
    """Return the scores that a record was made from."""
    values: dict[str, Any] = dict(record)
    return Scores(**(values | {"cost_ms": tuple(values["cost_ms"])}))


def total(parts: Iterable[Scores]) -> Scores:
    """Return the scores of all images together; of the costs, the median of medians and the largest percentile."""
    parts = list(parts)
    sums: dict[str, Any] = {
        name: sum(getattr(part, name) for part in parts)
        for name in (
            *("images", "in_view", "found", "false", "beyond_view", "found_beyond"),
            *("square_sum_m2", "square_sum_rad2"),
        )
    }
    reasons: dict[str, Any] = {
        name: dict(sorted(sum((Counter(getattr(part, name)) for part in parts), Counter[str]()).items()))
        for name in ("missed", "hidden")
    }
    medians, percentiles = zip(*(part.cost_ms for part in parts), strict=True) if parts else ((0.0,), (0.0,))
    return Scores(
        **sums,
        **reasons,
        max_m=max((part.max_m for part in parts), default=0.0),
        max_rad=max((part.max_rad for part in parts), default=0.0),
        cost_ms=(float(np.median(medians)), max(percentiles)),
    )


def target_rows(scores: Scores) -> list[tuple[str, str, str, str]]:
    """Return how the targets stand: quantity, target, measured value, and whether it is met."""
    share = scores.found / max(scores.in_view, 1)
    rows = [
        ("position error, RMS", "<= 4 mm", f"{MM * scores.rms_m:.2f} mm", MM * scores.rms_m <= 4.0),
        ("position error, maximum", "<= 12 mm", f"{MM * scores.max_m:.2f} mm", MM * scores.max_m <= 12.0),
        (
            "heading error, RMS",
            "<= 2 deg",
            f"{math.degrees(scores.rms_rad):.2f} deg",
            scores.rms_rad <= math.radians(2),
        ),
        ("robots in view that are found", ">= 99.9 %", f"{100.0 * share:.3f} %", share >= 0.999),
        ("false identities", "0", str(scores.false), scores.false == 0),
        ("processor time of an image, median", "<= 15 ms", f"{scores.cost_ms[0]:.1f} ms", scores.cost_ms[0] <= 15.0),
    ]
    return [(name, target, value, "yes" if met else "NO") for name, target, value, met in rows]


def as_markdown(scores: Scores, runs: int, warning: str) -> str:
    """Return the table of the study."""
    lines = [
        "# Camera study",
        "",
        *([warning, ""] if warning else []),
        f"{scores.images} images of {runs} cameras, {scores.in_view} robots in view.",
        "",
        f"| {' | '.join(TARGET_HEADER)} |",
        "| --- | --- | --- | --- |",
        *(f"| {' | '.join(row)} |" for row in target_rows(scores)),
        "",
        f"Largest heading error: {math.degrees(scores.max_rad):.2f} degrees. Processor time of an image, 99th "
        f"percentile of the slowest camera: {scores.cost_ms[1]:.1f} ms.",
        "",
        f"Robots in view without a fix: {_reasons(scores.missed)}.",
        f"Robots only partly in view, or missing: {scores.beyond_view}, of which {scores.found_beyond} had a fix; the "
        f"others: {_reasons(scores.hidden)}.",
        "",
    ]
    return "\n".join(lines)


def _reasons(counts: dict[str, int]) -> str:
    return ", ".join(f"{reason} {number}" for reason, number in counts.items()) or "none"
