"""Which two discs are a robot's cover: sizes, roundness, black backing and distance must all fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mission_computer.vision.config import VisionConfig
from mission_computer.vision.discs import Disc
from mission_computer.vision.resolution import coarseness
from mission_computer.vision.tracks import Track
from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.camera_report import Refusal, RobotFix
from swarm_msgs_py.types import FloatArray

CLEARLY_BETTER = 0.3
"""By how much the quality of one pair must exceed that of another to win without a track."""


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """What the discs of one color say of the robot that wears it.

    Attributes
    ----------
    result : RobotFix or Refusal
        Where it is, or why that is not known.
    own : tuple of Disc
        What is on its cover, as far as one can tell; the others are something else.
    """

    result: RobotFix | Refusal
    own: tuple[Disc, ...]


@dataclass(frozen=True, slots=True, eq=False)
class _Pair:
    """Two discs that could be a cover."""

    large: Disc
    small: Disc
    quality: float


@dataclass(frozen=True, slots=True, eq=False)
class Whereabouts:
    """What is known of where a robot may be, None for what is not.

    Attributes
    ----------
    track : Track or None
        Where it may be now.
    near : Track or None
        Where it may be if it stopped when it was seen last: what is elsewhere is not on its cover.
    left : Track or None
        From where it seems to have been carried. If a cover shows there and another one does elsewhere, one of them is
        a look-alike, and nobody knows which.
    """

    track: Track | None = None
    near: Track | None = None
    left: Track | None = None


NOWHERE = Whereabouts()
"""Nothing is known."""


def find_cover(
    marker: CoverMarker, discs: Sequence[Disc], config: VisionConfig, whereabouts: Whereabouts = NOWHERE
) -> Match:
    """Return where a robot is and the discs that tell it, or why that is not known.

    Parameters
    ----------
    marker : CoverMarker
    discs : sequence of Disc
        Everything of its color.
    config : VisionConfig
    whereabouts : Whereabouts
        Decides between several covers that fit. A single one is returned wherever it is.
    """
    large = [(disc, rest) for disc in discs if (rest := _slack(marker, disc, marker.large_radius, config)) > 0.0]
    small = [(disc, rest) for disc in discs if (rest := _slack(marker, disc, marker.small_radius, config)) > 0.0]
    pairs = [
        _Pair(one, other, min(one_rest, other_rest, rest))
        for one, one_rest in large
        for other, other_rest in small
        if (rest := _baseline_slack(one, other, marker, config)) > 0.0
    ]
    if not pairs:
        own = tuple(disc for disc in discs if _may_be_on(marker, disc, whereabouts.near, config))
        return Match(_why_none(marker, own, config), own)
    pair = _best(pairs, marker, whereabouts)
    if pair is None:
        return Match(Refusal.AMBIGUOUS, tuple(disc for pair in pairs for disc in (pair.large, pair.small)))
    return Match(_fix(marker, pair, config), (pair.large, pair.small))


def _may_be_on(marker: CoverMarker, disc: Disc, near: Track | None, config: VisionConfig) -> bool:
    """Return whether a blob may be on the cover of a robot: it is on black, as far as it shows, where the robot is."""
    is_there = near is None or near.may_be_at(disc.center, marker.radius)
    return is_there and (disc.is_cut or _is_backed(marker, disc, config))


def _slack(marker: CoverMarker, disc: Disc, radius: float, config: VisionConfig) -> float:
    """Return how far a blob is from being refused as a disc of a radius: 1 ideal, 0 or less refused.

    The fewer pixels a disc has, the less is known of it; its form suffers most, which is made of second moments.
    """
    if disc.is_cut or not _is_backed(marker, disc, config):
        return 0.0
    coarse = coarseness(radius / disc.pixel_m)
    used = (
        abs(disc.radius / radius - 1.0) / (config.radius_tolerance * coarse),
        (disc.elongation - 1.0) / ((config.elongation_max - 1.0) * coarse**2 + 1e-9),
        abs(disc.solidity - 1.0) / (config.solidity_tolerance * coarse**2),
    )
    return 1.0 - max(used)


def _is_backed(marker: CoverMarker, disc: Disc, config: VisionConfig) -> bool:
    """Return whether a blob lies on black; rims of covers are as wide as small discs, and as few pixels."""
    return disc.backing <= config.backing_max * coarseness(marker.small_radius / disc.pixel_m)


def _baseline_slack(large: Disc, small: Disc, marker: CoverMarker, config: VisionConfig) -> float:
    apart = float(np.hypot(*(small.center - large.center)))
    return 1.0 - abs(apart - marker.baseline) / config.baseline_tolerance_m


def _best(pairs: Sequence[_Pair], marker: CoverMarker, whereabouts: Whereabouts) -> _Pair | None:
    """Return the pair that is the robot, None if that is not clear."""
    left, track = whereabouts.left, whereabouts.track
    if left is not None and len({left.may_be_at(_middle(marker, pair)) for pair in pairs}) > 1:
        return None
    if track is not None:
        near = [pair for pair in pairs if track.may_be_at(_middle(marker, pair))]
        pairs = near or pairs
    ranked = sorted(pairs, key=lambda pair: -pair.quality)
    if len(ranked) > 1 and ranked[0].quality - ranked[1].quality < CLEARLY_BETTER:
        return None
    return ranked[0]


def _why_none(marker: CoverMarker, own: Sequence[Disc], config: VisionConfig) -> Refusal:
    """Return why the blobs that may be on a robot's cover are not two discs at the right distance."""
    if not own:
        return Refusal.NOT_SEEN
    has_large, has_small = (
        any(_slack(marker, disc, radius, config) > 0.0 for disc in own)
        for radius in (marker.large_radius, marker.small_radius)
    )
    if has_large and has_small:
        return Refusal.MISMATCH
    if any(disc.is_cut for disc in own):
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
