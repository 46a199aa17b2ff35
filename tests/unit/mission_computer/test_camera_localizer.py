from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from table_top import AWAY, BLUE, GREEN, MARKERS, PINK, RED, STARTS, YAWS, YELLOW, camera, localizer, moved, picture

from mission_computer.vision.calibration import find_marks
from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from mission_computer.vision.resolution import LEAST_RADIUS_PX, smallest_radius_px
from studies.camera_cases import plain_case
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import FloorMarks, MarkerColor
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.messages.camera_report import CameraReport, CameraStatus, Refusal
from swarm_sim.camera.overhead_camera import blacken_half
from swarm_sim.camera.raster import Spot

POSITION_M, HEADING_RAD = 0.002, math.radians(0.5)  # of one image; the targets are 4 mm RMS and 2 degrees RMS


@pytest.fixture(scope="module")
def ready() -> CameraLocalizer:
    """Return a localizer whose calibration is finished, and which no test makes any wiser."""
    made = localizer(reach_m=100.0)  # so that what other tests showed it decides nothing
    assert made.locate(picture(), camera().info).status is CameraStatus.OK
    return made


def look(ready: CameraLocalizer, image: CameraImage) -> CameraReport:
    return ready.locate(replace(image, time=image.time + 100.0), camera().info)


def reasons(report: CameraReport) -> dict[int, Refusal]:
    return {int(rejection.robot): rejection.reason for rejection in report.rejections}


def assert_true(report: CameraReport, positions: np.ndarray, yaws: np.ndarray = YAWS) -> None:
    for fix in report.fixes:
        off = (fix.yaw - yaws[fix.robot] + np.pi) % (2.0 * np.pi) - np.pi
        assert np.hypot(*(fix.position - positions[fix.robot])) < POSITION_M
        assert abs(off) < HEADING_RAD


def test_all_robots_are_where_they_are_said_to_be(ready: CameraLocalizer) -> None:
    report = look(ready, picture())

    assert [fix.robot for fix in report.fixes] == [RED, BLUE, GREEN, YELLOW, PINK]
    assert_true(report, STARTS)
    assert report.rejections == report.strays == ()
    assert report.dead_share == 0.0
    assert all(fix.quality > 0.3 for fix in report.fixes)


def test_the_first_image_already_gives_fixes_and_more_of_them_no_worse_ones() -> None:
    patient = localizer(calibration_frames=3)

    reports = [patient.locate(picture(number=number), camera().info) for number in range(4)]

    assert [len(report.fixes) for report in reports] == [5, 5, 5, 5]
    for report in reports:
        assert_true(report, STARTS)


def test_small_robots_have_less_certain_headings(ready: CameraLocalizer) -> None:
    fixes = look(ready, picture()).fixes

    assert fixes[YELLOW].yaw_sigma > 1.5 * fixes[RED].yaw_sigma
    assert fixes[YELLOW].yaw_sigma < math.radians(2.0)
    assert all(1e-5 < fix.position_sigma < 0.004 for fix in fixes)


@pytest.mark.parametrize("yaw", np.linspace(-3.1, 3.1, 5))
def test_headings_all_around(ready: CameraLocalizer, yaw: float) -> None:
    yaws = np.full(5, yaw)

    report = look(ready, picture(STARTS, yaws))

    assert len(report.fixes) == 5
    assert_true(report, STARTS, yaws)


def test_two_robots_that_touch_are_told_apart(ready: CameraLocalizer) -> None:
    positions = moved(PINK, (-0.15 + 0.161, 0.86))

    for facing in (YAWS, np.array([0.3, -2.0, 1.2, 0.0, np.pi])):  # the second time with the small discs side by side
        report = look(ready, picture(positions, facing))
        assert len(report.fixes) == 5
        assert_true(report, positions, facing)


def test_a_missing_robot_is_reported_and_the_others_are_found(ready: CameraLocalizer) -> None:
    report = look(ready, picture(moved(GREEN, AWAY)))

    assert reasons(report) == {GREEN: Refusal.NOT_SEEN}
    assert len(report.fixes) == 4


@pytest.mark.parametrize("yaw", [0.0, np.pi / 2.0, np.pi])
def test_a_robot_that_leaves_the_view_is_true_as_long_as_it_is_found_and_then_cut_off(
    ready: CameraLocalizer, yaw: float
) -> None:
    yaws, seen = YAWS.copy(), []
    yaws[GREEN] = yaw
    for x in np.arange(1.2, 1.62, 0.03):
        positions = moved(GREEN, (float(x), 0.0))
        report = look(ready, picture(positions, yaws))
        assert_true(report, positions, yaws)
        seen.append(reasons(report).get(GREEN))

    assert seen[0] is None
    assert Refusal.CUT_OFF in seen
    assert seen[-1] is Refusal.NOT_SEEN


def test_a_spot_in_a_robots_color_is_a_stray(ready: CameraLocalizer) -> None:
    red = MARKERS[RED]
    spots = (Spot(MarkerColor.RED, (0.2, 0.1), red.large_radius), Spot(MarkerColor.RED, (0.363, 0.1), red.small_radius))

    report = look(ready, picture(STARTS, YAWS, *spots))

    assert len(report.fixes) == 5
    assert_true(report, STARTS)
    assert sorted(round(stray.position[0], 1) for stray in report.strays) == [0.2, 0.3]


def test_spots_alone_are_no_robot(ready: CameraLocalizer) -> None:
    red = MARKERS[RED]
    spots = (
        Spot(MarkerColor.RED, (0.2, 0.1), red.large_radius),
        Spot(MarkerColor.RED, (0.2 + red.baseline, 0.1), red.small_radius),
    )

    report = look(ready, picture(moved(RED, AWAY), YAWS, *spots))

    assert reasons(report) == {RED: Refusal.NOT_SEEN}
    assert len(report.strays) == 2


def test_half_of_the_image_black_hides_what_is_there_and_nothing_else(ready: CameraLocalizer) -> None:
    image = picture()
    blacken_half(image.pixels)

    report = look(ready, image)

    assert report.dead_share == pytest.approx(0.5, abs=0.01)
    assert {int(fix.robot) for fix in report.fixes} == {GREEN, PINK}
    assert set(reasons(report)) == {RED, BLUE, YELLOW}
    assert_true(report, STARTS)


def test_discs_at_the_edge_of_a_dark_part_are_not_trusted(ready: CameraLocalizer) -> None:
    column, row = camera().optics.project(np.array([[*STARTS[GREEN], 0.12]]))[0].round().astype(int)
    image = picture()
    image.pixels[row - 40 : row + 40, column - 200 : column + 1] = 0

    report = look(ready, image)

    assert reasons(report).get(GREEN) in {Refusal.CUT_OFF, Refusal.ONE_DISC}


def test_a_dark_image_says_so(ready: CameraLocalizer) -> None:
    report = look(ready, CameraImage(0.0, np.zeros((480, 640, 3), dtype=np.uint8)))

    assert report.status is CameraStatus.DARK
    assert report.fixes == ()
    assert "dark" in report.note


def test_a_disc_that_something_covers_is_refused(ready: CameraLocalizer) -> None:
    marker = MARKERS[BLUE]
    ahead = np.array([np.cos(YAWS[BLUE]), np.sin(YAWS[BLUE])])
    place = STARTS[BLUE] + marker.large_place * ahead
    column, row = camera().optics.project(np.array([[*place, marker.height]]))[0].round().astype(int)
    image = picture()
    image.pixels[row - 15 : row + 1, column - 15 : column + 15] = (40, 40, 42)  # something black on its upper half

    assert reasons(look(ready, image)) == {BLUE: Refusal.ONE_DISC}


def test_a_distractor_far_from_a_robot_that_is_missing_does_not_make_it_a_deformed_one() -> None:
    eyes = localizer()
    eyes.locate(picture(), camera().info)
    image = picture(moved(GREEN, AWAY), YAWS, Spot(MarkerColor.GREEN, (0.1, 0.1), 0.05), number=1)

    report = eyes.locate(image, camera().info)

    assert reasons(report) == {GREEN: Refusal.NOT_SEEN}
    assert [stray.color for stray in report.strays] == [MarkerColor.GREEN]


def test_what_is_left_of_a_robot_that_is_cut_off_is_no_distractor(ready: CameraLocalizer) -> None:
    report = look(ready, picture(moved(RED, (-0.62, -1.12))))

    assert reasons(report) == {RED: Refusal.CUT_OFF}
    assert report.strays == ()


@pytest.mark.parametrize(("width", "height", "images"), [(320, 240, 20), (640, 480, 4), (1280, 960, 2)])
def test_images_of_any_common_size_are_read(width: int, height: int, images: int) -> None:
    eye, eyes = camera(seed=3, width_px=width, height_px=height), localizer()
    rng = np.random.default_rng(1)
    for number in range(images):
        case = plain_case(MARKERS, rng)
        image = eye.take(number, 100.0 * number, case.positions, case.yaws)
        assert image is not None
        report = eyes.locate(image, eye.info)

        assert report.rejections == report.strays == ()
        for fix in report.fixes:
            assert np.hypot(*(fix.position - case.positions[fix.robot])) < 0.006


def test_the_first_image_undoes_the_lens_for_few_points_only(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, undo = [], cv2.undistortPoints

    def counting(points: np.ndarray, *rest: object, **more: object) -> np.ndarray:
        asked.append(len(points))
        return undo(points, *rest, **more)  # type: ignore[call-overload,no-any-return]

    monkeypatch.setattr(cv2, "undistortPoints", counting)

    assert len(localizer().locate(picture(), camera().info).fixes) == 5
    assert 0 < sum(asked) < 5000  # of 307,200 pixels


def test_the_smallest_disc_in_pixels_tells_whether_a_camera_can_be_read() -> None:
    coarse, usual, none = (
        smallest_radius_px(MARKERS, camera(seed=3, height_px=rows, width_px=4 * rows // 3).info, 2.4)
        for rows in (240, 480, 180)
    )

    assert usual == pytest.approx(2.0 * coarse, rel=0.01)
    assert coarse > LEAST_RADIUS_PX > none


def test_without_marks_there_are_no_fixes_until_they_show() -> None:
    image, fresh = picture(), localizer()
    hidden = replace(image, pixels=image.pixels.copy())
    hidden.pixels[:60] = 190

    first, second = fresh.locate(hidden, camera().info), fresh.locate(image, camera().info)

    assert (first.status, second.status) == (CameraStatus.UNCALIBRATED, CameraStatus.OK)
    assert "marks" in first.note


def test_another_camera_is_calibrated_anew() -> None:
    other, eyes = camera(seed=8), localizer()
    eyes.locate(picture(), camera().info)
    shot = other.take(0, 1.0, STARTS, YAWS)
    assert shot is not None

    report = eyes.locate(shot, other.info)

    assert len(report.fixes) == 5
    assert_true(report, STARTS)


def test_a_camera_that_was_pushed_is_noticed_and_calibrated_anew() -> None:
    eyes = localizer(recheck_frames=3)
    for number in range(2):
        eyes.locate(picture(number=number), camera().info)
    pushed = replace(picture(), pixels=np.roll(picture().pixels, (4, -6), axis=(0, 1)))

    reports = [eyes.locate(pushed, camera().info) for _ in range(2)]

    assert [report.note for report in reports] == ["the camera has moved; it is calibrated anew", ""]
    assert len(reports[0].fixes) == 5
    for fix in reports[1].fixes:  # the pixels were rolled by 32 mm, and the lens with them
        assert np.hypot(*(fix.position - STARTS[fix.robot])) < 0.004


def test_marks_that_are_hidden_for_a_while_change_nothing() -> None:
    eyes = localizer(recheck_frames=1)
    eyes.locate(picture(), camera().info)
    hidden = picture()
    hidden.pixels[440:] = 190

    report = eyes.locate(hidden, camera().info)

    assert report.note == ""
    assert_true(report, STARTS)
    assert len(report.fixes) == 5


def test_a_mark_that_shows_in_part_is_no_push_of_the_camera() -> None:
    eyes = localizer(recheck_frames=1, moved_px=0.4)
    eyes.locate(picture(), camera().info)
    before, undisturbed = eyes.calibration, find_marks(picture().pixels)
    assert undisturbed is not None
    image = picture()
    column, row = undisturbed[0].round().astype(int)
    image.pixels[row - 12 : row + 13, column + 4 : column + 6] = 195  # the rim of the mark looks like the floor

    view = find_marks(image.pixels)
    report = eyes.locate(image, camera().info)

    assert view is not None
    assert (np.abs(view - undisturbed).max(axis=1) > 0.4).tolist() == [True, False, False, False]
    assert report.note == ""
    assert eyes.calibration is before


def test_an_image_of_another_size_than_its_camera_is_an_error() -> None:
    with pytest.raises(ValueError, match="640 x 480"):
        localizer().locate(CameraImage(0.0, np.zeros((10, 10, 3), dtype=np.uint8)), camera().info)


def test_two_robots_of_one_color_are_refused() -> None:
    with pytest.raises(ConfigError, match="color"):
        CameraLocalizer(VisionConfig(), (MARKERS[0], replace(MARKERS[1], color=MarkerColor.RED)), FloorMarks())


def test_equal_images_give_equal_reports() -> None:
    one, other = (localizer().locate(picture(), camera().info) for _ in range(2))

    assert [fix.position.tobytes() for fix in one.fixes] == [fix.position.tobytes() for fix in other.fixes]
    assert [fix.yaw for fix in one.fixes] == [fix.yaw for fix in other.fixes]
