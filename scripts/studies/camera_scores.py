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
IMAGES_ASKED = 10_000
"""Fewer images say too little of what must never happen."""
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
    cost_ms : (float, float, float)
        Median, 99th percentile and maximum of the processor time from an image to its fixes, calibration included [ms].
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
    cost_ms: tuple[float, float, float] = (0.0, 0.0, 0.0)

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
    """Return the scores of all images together; of the costs, the median of medians and the largest others."""
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
    costs = np.array([part.cost_ms for part in parts] or [(0.0, 0.0, 0.0)])
    return Scores(
        **sums,
        **reasons,
        max_m=max((part.max_m for part in parts), default=0.0),
        max_rad=max((part.max_rad for part in parts), default=0.0),
        cost_ms=(float(np.median(costs[:, 0])), *costs[:, 1:].max(axis=0).tolist()),
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
        *(
            (f"processor time of an image, {name}", "<= 15 ms", f"{cost:.1f} ms", cost <= 15.0)
            for name, cost in zip(("median", "99th percentile", "maximum"), scores.cost_ms, strict=True)
        ),
    ]
    judged = [(name, target, value, "yes" if met else "NO") for name, target, value, met in rows]
    verdict = "NO" if scores.false else "yes" if scores.images >= IMAGES_ASKED else "too few images"
    false = ("false identities", f"0 of >= {IMAGES_ASKED:,}", f"{scores.false} of {scores.images:,}", verdict)
    return [*judged, false]


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
        f"Largest heading error: {math.degrees(scores.max_rad):.2f} degrees. Of processor times the 99th percentile is "
        "that of the slowest camera; all count the first images, from which the camera is calibrated.",
        "",
        f"Robots in view without a fix: {_reasons(scores.missed)}.",
        f"Robots only partly in view, or missing: {scores.beyond_view}, of which {scores.found_beyond} had a fix; the "
        f"others: {_reasons(scores.hidden)}.",
        "",
    ]
    return "\n".join(lines)


def _reasons(counts: dict[str, int]) -> str:
    return ", ".join(f"{reason} {number}" for reason, number in counts.items()) or "none"
