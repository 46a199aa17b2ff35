"""Which two discs are a robot's cover: sizes, roundness, black backing and distance must all fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mission_computer.vision.config import VisionConfig
from mission_computer.vision.discs import Disc
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.camera_report import Refusal, RobotFix
from swarm_msgs_py.types import FloatArray

CLEARLY_BETTER = 0.3
"""By how much the quality of one pair must exceed that of another to win without a track."""


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where a robot was last.

    Attributes
    ----------
    position : (2,) array
        [m].
    reach : float
        How far it may be from there by now [m].
    """

    position: FloatArray
    reach: float


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Two discs that could be a cover."""

    large: Disc
    small: Disc
    quality: float


def find_cover(
    marker: CoverMarker, discs: Sequence[Disc], track: Track | None, config: VisionConfig
) -> tuple[RobotFix, tuple[Disc, Disc]] | Refusal:
    """Return where a robot is and the two discs that tell it, or why that is not known.

    Parameters
    ----------
    marker : CoverMarker
    discs : sequence of Disc
        Everything of its color.
    track : Track or None
        Only decides between several covers that fit.
    config : VisionConfig
    """
    if not discs:
        return Refusal.NOT_SEEN
    large = [(disc, rest) for disc in discs if (rest := _slack(disc, marker.large_radius, config)) > 0.0]
    small = [(disc, rest) for disc in discs if (rest := _slack(disc, marker.small_radius, config)) > 0.0]
    pairs = [
        _Pair(one, other, min(one_rest, other_rest, rest))
        for one, one_rest in large
        for other, other_rest in small
        if (rest := _baseline_slack(one, other, marker, config)) > 0.0
    ]
    if not pairs:
        return _why_none(discs, bool(large), bool(small))
    pair = _best(pairs, marker, track)
    if pair is None:
        return Refusal.AMBIGUOUS
    return _fix(marker, pair, config), (pair.large, pair.small)


def _slack(disc: Disc, radius: float, config: VisionConfig) -> float:
    """Return how far a blob is from being refused as a disc of a radius: 1 ideal, 0 or less refused."""
    if disc.is_cut or disc.backing > config.backing_max:
        return 0.0
    used = (
        abs(disc.radius / radius - 1.0) / config.radius_tolerance,
        (disc.elongation - 1.0) / (config.elongation_max - 1.0 + 1e-9),
        abs(disc.solidity - 1.0) / config.solidity_tolerance,
    )
    return 1.0 - max(used)


def _baseline_slack(large: Disc, small: Disc, marker: CoverMarker, config: VisionConfig) -> float:
    apart = float(np.hypot(*(small.center - large.center)))
    return 1.0 - abs(apart - marker.baseline) / config.baseline_tolerance_m


def _best(pairs: Sequence[_Pair], marker: CoverMarker, track: Track | None) -> _Pair | None:
    """Return the pair that is the robot, None if that is not clear."""
    if track is not None and len(pairs) > 1:
        near = [pair for pair in pairs if np.hypot(*(_middle(marker, pair) - track.position)) <= track.reach]
        pairs = near or pairs
    ranked = sorted(pairs, key=lambda pair: -pair.quality)
    if len(ranked) > 1 and ranked[0].quality - ranked[1].quality < CLEARLY_BETTER:
        return None
    return ranked[0]


def _why_none(discs: Sequence[Disc], has_large: bool, has_small: bool) -> Refusal:
    if has_large and has_small:
        return Refusal.MISMATCH
    if any(disc.is_cut for disc in discs):
        return Refusal.CUT_OFF
    return Refusal.ONE_DISC if has_large or has_small else Refusal.DEFORMED


def _middle(marker: CoverMarker, pair: _Pair) -> FloatArray:
    share = -marker.large_place / marker.baseline
    middle: FloatArray = pair.large.center + share * (pair.small.center - pair.large.center)
    return middle


def _fix(marker: CoverMarker, pair: _Pair, config: VisionConfig) -> RobotFix:
    ahead = pair.small.center - pair.large.center
    share = -marker.large_place / marker.baseline
    center_sigma = config.center_sigma_px * pair.large.pixel_m
    return RobotFix(
        robot=marker.robot,
        position=_middle(marker, pair),
        yaw=float(np.arctan2(ahead[1], ahead[0])),
        position_sigma=float(np.hypot(config.calibration_sigma_m, center_sigma * np.hypot(share, 1.0 - share))),
        yaw_sigma=float(np.sqrt(2.0)) * center_sigma / marker.baseline,
        quality=pair.quality,
    )
