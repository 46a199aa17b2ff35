"""Robots do not leap: a cover that shows elsewhere is a look-alike, or its robot was carried."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose
from table_top import AWAY, PINK, STARTS, YAWS, camera, localizer, moved, picture

from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.messages.camera_report import CameraReport, Refusal

POSITION_M = 0.002


def reasons(report: CameraReport) -> dict[int, Refusal]:
    return {int(rejection.robot): rejection.reason for rejection in report.rejections}


def assert_true(report: CameraReport) -> None:
    for fix in report.fixes:
        assert np.hypot(*(fix.position - STARTS[fix.robot])) < POSITION_M


def look_alike(number: int, *, robot_too: bool) -> CameraImage:
    """Return an image in which pink's cover shows at (0, -0.1), and nowhere else unless `robot_too`."""
    image = picture(number=number) if robot_too else picture(moved(PINK, AWAY), number=number)
    twin = picture(moved(PINK, (0.0, -0.1)), number=number)
    column, row = camera().optics.project(np.array([[0.0, -0.1, 0.12]]))[0].round().astype(int)
    part = (slice(row - 24, row + 24), slice(column - 24, column + 24))
    image.pixels[part] = twin.pixels[part]
    return image


def test_two_covers_of_one_color_are_told_apart_by_the_track_only() -> None:
    """A photograph of a robot lies on the floor: copied pixels, of the same height as far as one image can tell."""
    image, twin = picture(), picture(moved(PINK, (0.0, -0.1)), number=1)
    both = picture()
    column, row = camera().optics.project(np.array([[0.0, -0.1, 0.12]]))[0].round().astype(int)
    part = (slice(row - 24, row + 24), slice(column - 24, column + 24))
    both.pixels[part] = twin.pixels[part]

    fresh, tracking = localizer(), localizer()
    assert fresh.locate(both, camera().info).rejections[0].reason is Refusal.AMBIGUOUS
    tracking.locate(image, camera().info)
    known = tracking.locate(replace(both, time=0.1), camera().info)
    assert known.rejections == ()
    assert_allclose(known.fixes[PINK].position, STARTS[PINK], atol=POSITION_M)


def test_a_look_alike_of_a_robot_that_is_hidden_is_no_fix() -> None:
    eyes = localizer()
    eyes.locate(picture(), camera().info)

    reports = [eyes.locate(look_alike(number, robot_too=False), camera().info) for number in range(1, 9)]
    back = eyes.locate(look_alike(9, robot_too=True), camera().info)

    assert {reasons(report)[PINK] for report in reports} == {Refusal.ELSEWHERE}
    assert all(len(report.strays) == 2 for report in reports)
    assert len(back.fixes) == 5
    assert_true(back)


def test_a_robot_that_was_carried_is_believed_after_some_images_in_a_row() -> None:
    eyes, elsewhere = localizer(moved_images=4), moved(PINK, (0.0, -0.1))
    eyes.locate(picture(), camera().info)

    counts = []
    for number in range(1, 9):
        is_gap = number == 3
        shown = picture(moved(PINK, AWAY) if is_gap else elsewhere, number=number)
        counts.append(len(eyes.locate(shown, camera().info).fixes))

    assert counts == [4, 4, 4, 4, 4, 4, 5, 5]


def test_a_robot_that_comes_back_beside_the_look_alike_that_was_taken_for_it_is_ambiguous() -> None:
    eyes = localizer(moved_images=3)
    eyes.locate(picture(), camera().info)

    alone = [eyes.locate(look_alike(number, robot_too=False), camera().info) for number in range(1, 6)]
    both = eyes.locate(look_alike(6, robot_too=True), camera().info)
    robot = [eyes.locate(picture(number=number), camera().info) for number in range(7, 10)]
    again = eyes.locate(look_alike(10, robot_too=True), camera().info)

    assert [len(report.fixes) for report in alone] == [4, 4, 5, 5, 5]
    assert reasons(both) == {PINK: Refusal.AMBIGUOUS}
    assert [len(report.fixes) for report in robot] == [4, 4, 5]
    assert_true(robot[-1])
    assert reasons(again) == {PINK: Refusal.AMBIGUOUS}


def test_a_robot_that_drives_back_to_where_it_was_carried_from_has_a_track_as_any_other() -> None:
    eyes, place = localizer(moved_images=1), np.array([0.3, 0.8])
    eyes.locate(picture(), camera().info)

    eyes.locate(picture(moved(PINK, (0.3, 0.8)), number=1), camera().info)
    back = eyes.locate(replace(picture(), time=2.0), camera().info)
    both = eyes.locate(replace(look_alike(1, robot_too=True), time=2.1), camera().info)

    assert np.hypot(*(place - STARTS[PINK])) < 2.0 * VisionConfig().reach_mps
    assert (len(back.fixes), len(both.fixes)) == (5, 5)
    assert_true(both)


def test_a_look_alike_that_leaps_about_is_never_believed() -> None:
    eyes = localizer(moved_images=3)
    eyes.locate(picture(), camera().info)

    places = [(0.0, -0.1), (0.2, -0.1)] * 4
    shown = [picture(moved(PINK, place), number=number + 1) for number, place in enumerate(places)]

    assert {len(eyes.locate(image, camera().info).fixes) for image in shown} == {4}


def test_a_robot_that_was_not_seen_for_long_is_found_wherever_it_is() -> None:
    eyes = localizer()
    eyes.locate(picture(), camera().info)

    report = eyes.locate(replace(picture(moved(PINK, (0.0, -0.1))), time=10.0), camera().info)

    assert len(report.fixes) == 5


def test_a_camera_that_was_replaced_knows_nothing_of_where_robots_were() -> None:
    other, eyes = camera(seed=8), localizer()
    eyes.locate(picture(), camera().info)
    shot = other.take(0, 0.1, moved(PINK, (0.0, -0.1)), YAWS)
    assert shot is not None

    assert len(eyes.locate(shot, other.info).fixes) == 5
