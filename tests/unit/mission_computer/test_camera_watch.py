"""What the operator hears of the camera, and what the robots are told."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from table_top import AWAY, GREEN, MARKERS, PINK, RED, STARTS, YAWS, camera, moved, picture

from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from mission_computer.vision.camera_watch import CameraWatch, fixes_of
from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.body_codec import decode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_frame
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.bodies import CameraFixes
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.messages.radio import Packet
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.camera.overhead_camera import blacken_half
from swarm_sim.camera.raster import Spot

DT = 0.1
CONFIG = VisionConfig(calibration_frames=1, reach_m=100.0)


class Table:
    """A watch that is shown one image after the other."""

    def __init__(self) -> None:
        self.watch, self.number = CameraWatch(CONFIG, MARKERS), -1

    def show(self, image: CameraImage | None, times: int = 1) -> str:
        """Show an image for some ticks and return all that was said."""
        said = []
        for _ in range(times):
            self.number += 1
            time = self.number * DT
            shown = None if image is None else CameraImage(time, image.pixels)
            report = self.watch.look(time, shown, camera().info)
            said.append(self.watch.notice(time, report))
        return "; ".join(filter(None, said))


def black(image: CameraImage, *, wholly: bool = False) -> CameraImage:
    pixels = image.pixels.copy()
    if wholly:
        pixels[:] = 0
    blacken_half(pixels)
    return CameraImage(image.time, pixels)


def test_as_long_as_all_is_well_nothing_is_said() -> None:
    assert Table().show(picture(), 8) == ""


def test_a_missing_robot_is_reported_once_after_a_moment_and_so_is_its_return() -> None:
    table = Table()

    assert table.show(picture(moved(PINK, AWAY)), 2) == ""
    assert table.show(picture(moved(PINK, AWAY)), 8) == "r04 (pink): not seen"
    assert table.show(picture(), 6) == ""
    assert table.show(picture(), 3) == "r04 (pink): well again"


def test_a_robot_that_is_missing_in_two_of_three_images_is_reported_once() -> None:
    table, missing = Table(), picture(moved(PINK, AWAY))

    said = [table.show(image) for _ in range(20) for image in (picture(), missing, missing)]

    assert list(filter(None, said)) == ["r04 (pink): not seen"]
    assert said.index("r04 (pink): not seen") < 10
    assert table.show(picture(), 10) == "r04 (pink): well again"


def test_a_robot_that_is_missed_in_one_of_three_images_is_not_reported() -> None:
    table, missing = Table(), picture(moved(PINK, AWAY))

    assert [table.show(image) for _ in range(10) for image in (picture(), picture(), missing)] == [""] * 30


def test_a_reason_that_changes_from_image_to_image_is_reported_once_and_another_one_when_it_stays() -> None:
    table, out, half = Table(), picture(moved(RED, AWAY)), picture(moved(RED, (-0.62, -1.12)))

    said = [table.show(image) for _ in range(15) for image in (half, out)]

    assert [line for line in said if line] == ["r00 (red): not seen"]
    assert said.index("r00 (red): not seen") == 3
    assert table.show(half, 12) == "r00 (red): cut off"


def test_a_share_of_black_pixels_between_two_steps_is_told_once() -> None:
    table, shares = Table(), (0.449, 0.452, 0.455, 0.446)
    images = []
    for share in shares:
        image = picture()
        image.pixels[:, : round(share * 640)] = 0
        images.append(image)
    table.show(picture())

    said = [table.show(image) for _ in range(8) for image in images]

    assert sum("of the image are black" in line for line in said) == 1


def test_a_push_of_the_camera_is_told_in_the_image_in_which_it_is_found() -> None:
    watch = CameraWatch(replace(CONFIG, recheck_frames=3), MARKERS)
    pushed = np.roll(picture().pixels, (4, -6), axis=(0, 1))

    said = []
    for number in range(8):
        time = DT * number
        image = CameraImage(time, picture().pixels if number < 2 else pushed)
        said.append(watch.notice(time, watch.look(time, image, camera().info)))

    assert list(filter(None, said)) == ["camera: the camera has moved; it is calibrated anew"]


def test_a_missing_robot_is_told_beside_where_something_of_its_color_lies() -> None:
    spots = (Spot(MarkerColor.GREEN, (0.1, 0.1), 0.05), Spot(MarkerColor.GREEN, (-0.3, 0.2), 0.05))
    table = Table()
    table.show(picture(), 2)

    said = table.show(picture(moved(GREEN, AWAY), YAWS, *spots), 6)

    assert "r02 (green): not seen (2 blobs of its color)" in said
    assert re.search(r"green: something of this color is no robot, at \(\S+, 0\.\d\d\), \(\S+, 0\.\d\d\) m", said)


def test_a_robot_that_is_cut_off_is_not_told_as_a_distractor_too() -> None:
    assert Table().show(picture(moved(RED, (-0.62, -1.12))), 12) == "r00 (red): cut off"


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (picture(moved(RED, (-0.62, -1.12))), "r00 (red): cut off"),
        (
            picture(STARTS, YAWS, Spot(MarkerColor.GREEN, (0.1, 0.1), 0.05)),
            "green: something of this color is no robot",
        ),
        (picture(np.array([(0.0, 0.0), (0.27, 0.0), *STARTS[2:]])), "r00 and r01: they touch"),
    ],
    ids=["partly out of view", "distractor", "touching"],
)
def test_what_is_wrong_with_the_picture_is_said_in_words(image: CameraImage, words: str) -> None:
    assert words in Table().show(image, 6)


def test_a_camera_that_fails_and_comes_back_is_reported_and_hides_nothing() -> None:
    table = Table()
    table.show(picture(moved(PINK, AWAY)), 6)

    assert table.show(None, 10) == "camera: no images; robots stand still"
    assert table.show(picture(moved(PINK, AWAY)), 12) == "camera: well again"


def test_half_a_picture_is_reported_with_those_whom_it_hides() -> None:
    table = Table()
    table.show(picture(), 3)
    said = table.show(black(picture()), 6)

    assert "camera: 50 % of the image are black" in said
    assert "r01 (blue): not seen" in said
    assert "r02" not in said


def test_a_dark_picture_says_nothing_of_robots() -> None:
    table = Table()
    table.show(picture(), 3)

    assert table.show(black(picture(), wholly=True), 8) == "camera: the image is dark"


def test_the_last_image_is_drawn_with_the_shape_that_is_asked_for() -> None:
    table = Table()
    assert table.watch.picture() is None
    table.show(picture())

    drawn = table.watch.picture()
    assert drawn is not None
    assert drawn.shape == picture().pixels.shape


def test_robots_are_told_of_an_image_that_shows_some_of_them_and_of_no_other() -> None:
    watch = CameraWatch(CONFIG, MARKERS)
    report = watch.look(0.0, picture(moved(RED, AWAY)), camera().info)

    told = fixes_of(report, 7)
    assert told is not None
    assert (told.tick, [fix.robot for fix in told.fixes]) == (7, [1, 2, 3, 4])
    assert fixes_of(None, 7) is None
    assert fixes_of(watch.look(0.1, black(picture(), wholly=True), camera().info), 8) is None


def types() -> tuple[RobotType, ...]:
    kinds = {1: 0.16, 2: 0.11, 3: 0.08}
    made = {n: RobotType(type=n, mass_kg=1.0, mu1=0.5, mu2=0.1, coverage_radius_m=r) for n, r in kinds.items()}
    return tuple(made[n] for n in (1, 2, 2, 3, 3))


def square(half: float) -> FloatArray:
    return half * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def test_the_mission_computer_broadcasts_what_it_sees_in_the_same_tick() -> None:
    config = MissionConfig(vision=CONFIG)
    mission = Mission(config, NetworkConfig(), Roster.of(types()), (), square(3.0), DT, markers=MARKERS)

    outputs = mission.step(MissionInputs(0, 0.0, (), None, picture(), camera().info))

    sent = list(filter(None, map(fixes_in, outputs.outbox)))
    assert [fixes.tick for fixes in sent] == [0]
    for fix, place, yaw in zip(sent[0].fixes, STARTS, YAWS, strict=True):
        assert np.hypot(*(fix.position - place)) < 0.004
        assert abs(fix.yaw - yaw) < np.deg2rad(2.0)
    assert outputs.report.camera is not None
    assert [int(fix.robot) for fix in outputs.report.camera.fixes] == [NodeId(n) for n in range(5)]
    assert mission.has_camera
    assert mission.picture() is not None


def fixes_in(frame: bytes) -> CameraFixes | None:
    packet = decode_frame(frame)
    try:
        body = decode_body(packet.body) if isinstance(packet, Packet) else None
    except FrameError:
        return None
    return body if isinstance(body, CameraFixes) else None
