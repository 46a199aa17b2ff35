"""Images over ROS: the messages are what every tool reads, and a run under the camera is the same with and without."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo as CameraInfoMessage
from sensor_msgs.msg import Image, Imu

from bringup.compose import ScenarioActors
from bringup.filming import FilmOrder
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.ros_engine import RosEngine
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_msgs_py import topics
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo
from swarm_msgs_py.messages.sensing import ImuSample
from swarm_msgs_py.ros import camera, cdr, convert

TICKS = 25
PIXELS = np.random.default_rng(3).integers(0, 256, (7, 5, 3), dtype=np.uint8)


def test_an_image_message_says_what_a_ros_tool_expects_to_read() -> None:
    message = deserialize_message(camera.encode_image(CameraImage(12.5, PIXELS)), Image)

    stamp = message.header.stamp
    assert (message.header.frame_id, stamp.sec, stamp.nanosec) == ("camera", 12, 500_000_000)
    assert (message.height, message.width, message.encoding, message.step) == (7, 5, "rgb8", 15)
    assert message.is_bigendian == 0
    assert bytes(message.data) == PIXELS.tobytes()


def test_an_image_is_read_as_the_middleware_writes_it() -> None:
    message = deserialize_message(camera.encode_image(CameraImage(0.3, PIXELS)), Image)
    image = camera.decode_image(serialize_message(message))

    assert image.time == 0.3
    assert np.array_equal(image.pixels, PIXELS)
    assert not image.pixels.flags.writeable


@pytest.mark.parametrize("cut", [10, 30, 60, -1])
def test_an_image_that_is_cut_short_is_refused(cut: int) -> None:
    with pytest.raises(cdr.MessageError):
        camera.decode_image(camera.encode_image(CameraImage(0.3, PIXELS))[:cut])


def test_an_image_in_another_encoding_is_refused() -> None:
    message = Image(height=7, width=5, encoding="bgr8", step=15, data=PIXELS.tobytes())

    with pytest.raises(cdr.MessageError, match="bgr8"):
        camera.decode_image(serialize_message(message))


def test_what_is_known_of_the_camera_survives_its_message() -> None:
    info = CameraInfo(640, 480, np.array([[500.0, 0.0, 320.5], [0.0, 501.0, 239.5], [0.0, 0.0, 1.0]]), np.arange(5) / 9)
    message = deserialize_message(
        serialize_message(camera.info_message(info, Time(sec=3, nanosec=500_000_000))), CameraInfoMessage
    )
    again = camera.info_of(message)

    stamp = message.header.stamp
    assert (message.header.frame_id, stamp.sec, stamp.nanosec) == ("camera", 3, 500_000_000)
    assert (again.width, again.height) == (640, 480)
    assert again.intrinsics.tobytes() == info.intrinsics.tobytes()
    assert again.distortion.tobytes() == info.distortion.tobytes()
    assert list(message.p) == [500.0, 0.0, 320.5, 0.0, 0.0, 501.0, 239.5, 0.0, 0.0, 0.0, 1.0, 0.0]
    message.distortion_model = "fisheye"
    with pytest.raises(cdr.MessageError, match="fisheye"):
        camera.info_of(message)


def test_a_robot_without_a_compass_says_so_as_the_message_has_it() -> None:
    data = convert.encode_imu(cdr.stamp(0.1), "r00/base_link", ImuSample(np.zeros(2), None, 0.5))

    assert deserialize_message(data, Imu).orientation_covariance[0] == -1.0
    assert convert.decode_imu(data)[1].yaw is None


@pytest.fixture
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of its own: in that for temporary files nothing may be left."""
    return tmp_path_factory.mktemp("films")


@pytest.mark.usefixtures("domain_id", "nothing_left")
def test_a_run_under_the_camera_is_the_same_to_the_byte_as_without_ros(films: Path) -> None:
    """With images that PyBullet draws, though its physics takes no part."""
    settings = (
        *("sim.physics.backend=massdamper", "sim.camera.renderer=bullet"),
        *("sim.camera.off_from_s=1.0", "sim.camera.off_for_s=0.3"),
    )
    actors = ScenarioActors(resolve(*load_scenario("arena", tuple(map(parse_assignment, settings)))))
    film = films / "camera.mp4"
    with RosEngine(actors, film=FilmOrder(film, 10.0, actors.period_s)) as engine:
        records = list(islice(engine.ticks(), TICKS))
    with InProcessEngine(actors) as reference:
        expected = list(islice(reference.ticks(), TICKS))

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert (record.camera is None) == (wanted.camera is None) == (10 <= record.tick < 13)
        if record.camera is not None and wanted.camera is not None:
            assert [fix.position.tolist() for fix in record.camera.fixes] == [
                fix.position.tolist() for fix in wanted.camera.fixes
            ]
        assert {robot: its.yaw for robot, its in record.reports.items()} == {
            robot: its.yaw for robot, its in wanted.reports.items()
        }
    assert np.hypot(*(records[-1].truth.samples[-1] - records[0].truth.positions).T).min() > 0.05
    assert film.stat().st_size > 10_000


def test_images_and_what_is_known_of_the_camera_have_their_topics() -> None:
    table = topics.all_topics((), has_camera=True)

    assert table["/world/camera/image_raw"] == "sensor_msgs/msg/Image"
    assert table["/world/camera/camera_info"] == "sensor_msgs/msg/CameraInfo"
    assert "/world/camera/image_raw" not in topics.all_topics(())
