from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from mission_computer.vision.config import VisionConfig
from mission_computer.vision.covers import Match, Whereabouts, find_cover
from mission_computer.vision.discs import Disc
from mission_computer.vision.tracks import Track
from swarm_msgs_py.markers import CoverMarker, MarkerColor
from swarm_msgs_py.messages.camera_report import Refusal, RobotFix
from swarm_msgs_py.types import NodeId

MARKER = CoverMarker(robot=NodeId(3), color=MarkerColor.YELLOW, radius=0.08)
CONFIG = VisionConfig()


def disc(x: float, y: float, radius: float, **changes: object) -> Disc:
    ideal = Disc(MarkerColor.YELLOW, np.array([x, y]), radius, 1.0, 1.0, 0.03, False, 0.0045)
    return replace(ideal, **changes)  # type: ignore[arg-type]


def cover(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> tuple[Disc, Disc]:
    ahead = np.array([np.cos(yaw), np.sin(yaw)])
    large, small = np.array([x, y]) + MARKER.large_place * ahead, np.array([x, y]) + MARKER.small_place * ahead
    return disc(*large, MARKER.large_radius), disc(*small, MARKER.small_radius)


def found(*discs: Disc, config: VisionConfig = CONFIG, **known: Track) -> Match:
    return find_cover(MARKER, discs, config, Whereabouts(**known))


def fix_of(match: Match) -> RobotFix:
    assert isinstance(match.result, RobotFix)
    return match.result


def test_the_position_is_the_middle_of_the_cover_and_the_heading_points_from_the_large_to_the_small_disc() -> None:
    fix = fix_of(found(*cover(0.3, -0.2, 2.0)))

    assert fix.robot == 3
    assert_allclose(fix.position, (0.3, -0.2), atol=1e-12)
    assert fix.yaw == pytest.approx(2.0)
    assert fix.quality == pytest.approx(1.0)


def test_discs_that_are_a_little_off_have_less_quality() -> None:
    large, small = cover()

    fix = fix_of(found(replace(large, radius=1.06 * large.radius), small))

    assert fix.quality == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"radius": 0.6 * MARKER.small_radius}, Refusal.ONE_DISC),
        ({"elongation": 1.3}, Refusal.ONE_DISC),
        ({"solidity": 0.8}, Refusal.ONE_DISC),
        ({"backing": 0.8}, Refusal.ONE_DISC),
        ({"is_cut": True}, Refusal.CUT_OFF),
        ({"center": np.array([0.06, 0.0])}, Refusal.MISMATCH),
    ],
)
def test_a_small_disc_that_is_not_as_on_the_cover_is_refused(changes: dict[str, object], reason: Refusal) -> None:
    large, small = cover()

    assert found(large, replace(small, **changes)).result is reason  # type: ignore[arg-type]


def test_nothing_seen_one_disc_and_no_disc_at_all_have_their_own_reasons() -> None:
    large, _ = cover()

    assert found().result is Refusal.NOT_SEEN
    assert found(large).result is Refusal.ONE_DISC
    assert found(replace(large, solidity=0.5)).result is Refusal.DEFORMED


def test_a_blob_that_is_not_on_black_where_the_robot_was_is_not_its_own() -> None:
    large, _ = cover()
    ragged = replace(large, solidity=0.5)
    here, there = Track(np.array([0.05, 0.0]), 0.05), Track(np.array([0.5, 0.0]), 0.05)

    shown, elsewhere, lit = (
        found(ragged, near=here),
        found(ragged, near=there),
        found(replace(ragged, backing=0.9), near=here),
    )
    assert (shown.result, shown.own) == (Refusal.DEFORMED, (ragged,))
    assert (elsewhere.result, elsewhere.own) == (lit.result, lit.own) == (Refusal.NOT_SEEN, ())


def test_discs_of_few_pixels_may_be_less_round_and_no_others() -> None:
    large, small = cover()
    rough = replace(small, elongation=1.3, solidity=0.8, radius=1.15 * small.radius)

    assert found(large, rough).result is Refusal.ONE_DISC
    assert fix_of(found(*(replace(one, pixel_m=0.0091) for one in (large, rough)))).quality > 0.1


def test_the_better_of_two_pairs_wins_if_it_is_much_better() -> None:
    large, small = cover()
    twin = replace(small, center=small.center + np.array([0.0, 0.001]), radius=1.08 * small.radius)

    assert_allclose(fix_of(found(large, twin, small)).position, (0.0, 0.0), atol=1e-12)


def test_two_covers_are_ambiguous_unless_the_robot_cannot_have_gone_to_one_of_them() -> None:
    discs = (*cover(), *cover(0.5, 0.5))

    assert found(*discs).result is Refusal.AMBIGUOUS
    assert found(*discs, track=Track(np.array([0.2, 0.2]), 2.0)).result is Refusal.AMBIGUOUS
    near = fix_of(found(*discs, track=Track(np.array([0.48, 0.5]), 0.1)))
    assert_allclose(near.position, (0.5, 0.5), atol=1e-12)


def test_a_cover_where_the_robot_was_before_it_was_carried_makes_it_ambiguous() -> None:
    here, there = Track(np.array([0.5, 0.5]), 0.1), Track(np.zeros(2), 0.1)

    assert found(*cover(), *cover(0.5, 0.5), track=here, left=there).result is Refusal.AMBIGUOUS
    assert_allclose(fix_of(found(*cover(0.5, 0.5), track=here, left=there)).position, (0.5, 0.5), atol=1e-12)


def test_the_larger_the_pixels_the_less_certain_the_fix() -> None:
    exact = replace(CONFIG, calibration_sigma_m=0.0)
    fine, coarse = (
        fix_of(found(*(replace(one, pixel_m=size) for one in cover()), config=exact)) for size in (0.002, 0.004)
    )
    real = fix_of(found(*cover()))

    assert real.position_sigma > CONFIG.calibration_sigma_m  # however small the pixels
    assert coarse.position_sigma == pytest.approx(2.0 * fine.position_sigma)
    assert coarse.yaw_sigma == pytest.approx(2.0 * fine.yaw_sigma)
