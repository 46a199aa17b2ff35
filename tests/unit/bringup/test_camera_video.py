"""The video of the camera: complete when a run is over, and readable up to its last image when a process dies."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import cv2
import numpy as np
import pytest

from bringup.camera_video import ImageStream, make_video
from bringup.filming import FilmOrder, develop
from swarm_msgs_py.errors import SwarmError

REDS = (0, 100, 200)


def frame(red: int) -> np.ndarray:
    return np.full((48, 64, 3), (red, 40, 10), dtype=np.uint8)


def shots(path: Path) -> list[np.ndarray]:
    played, images = cv2.VideoCapture(str(path)), []
    while True:
        is_read, image = played.read()
        if not is_read:
            return images
        images.append(image)


def test_a_video_plays_back_the_images_in_order_and_color(tmp_path: Path) -> None:
    raw, path = tmp_path / "camera.mjpeg", tmp_path / "camera.mp4"
    stream = ImageStream(raw)
    for red in REDS:
        stream.add(frame(red))
    stream.close()
    stream.close()
    make_video(raw, path, 10.0)

    assert cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    assert [round(float(shot[:, :, 2].mean()) / 100.0) for shot in shots(path)] == [0, 1, 2]  # blue, green, red
    assert not raw.exists()


def test_all_images_of_a_process_that_is_killed_are_in_the_video(tmp_path: Path) -> None:
    order = FilmOrder(tmp_path / "camera.mp4", 10.0, 0.1)
    child = os.fork()
    if child == 0:
        stream = ImageStream(order.raw)
        for number in range(12):
            stream.add(frame(20 * number))
        os.kill(os.getpid(), signal.SIGKILL)
    _, status = os.waitpid(child, 0)

    assert os.WTERMSIG(status) == signal.SIGKILL
    assert len(shots(order.raw)) == 12  # the orchestrator may have died, too
    assert develop(order) == ()
    assert len(shots(order.path)) == 12


def test_without_images_there_is_no_file(tmp_path: Path) -> None:
    order = FilmOrder(tmp_path / "none.mp4", 10.0, 0.1)
    ImageStream(order.raw).close()

    assert develop(order) == ()
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(SwarmError, match="cannot be written"):
        ImageStream(tmp_path / "missing" / "camera.mjpeg").add(frame(0))


def test_a_video_that_cannot_be_made_is_told_and_its_images_stay(tmp_path: Path) -> None:
    order = FilmOrder(tmp_path / "camera.mp4", 10.0, 0.1)
    stream = ImageStream(order.raw)
    stream.add(frame(0))
    stream.close()
    order.path.mkdir()

    assert "no film" in develop(order)[0]
    assert order.raw.exists()


def test_an_image_of_another_size_is_refused(tmp_path: Path) -> None:
    stream = ImageStream(tmp_path / "camera.mjpeg")
    stream.add(frame(0))

    with pytest.raises(ValueError, match="64"):
        stream.add(np.zeros((10, 10, 3), dtype=np.uint8))
    stream.close()
