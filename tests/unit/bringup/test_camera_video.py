from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from bringup.camera_video import CameraVideo
from swarm_msgs_py.errors import SwarmError


def frame(red: int) -> np.ndarray:
    return np.full((48, 64, 3), (red, 40, 10), dtype=np.uint8)


def test_a_video_plays_back_the_images_in_order_and_color(tmp_path: Path) -> None:
    path = tmp_path / "camera.mp4"
    video = CameraVideo(path, 10.0)
    for red in (0, 100, 200):
        video.add(frame(red))
    video.close()
    video.close()

    played = cv2.VideoCapture(str(path))
    shots = [played.read()[1] for _ in range(3)]

    assert played.get(cv2.CAP_PROP_FPS) == pytest.approx(10.0)
    assert not played.read()[0]
    assert [round(float(shot[:, :, 2].mean()) / 100.0) for shot in shots] == [0, 1, 2]  # OpenCV reads blue, green, red


def test_without_images_there_is_no_file(tmp_path: Path) -> None:
    CameraVideo(tmp_path / "none.mp4", 10.0).close()

    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(SwarmError, match="cannot be written"):
        CameraVideo(tmp_path / "missing" / "camera.mp4", 10.0).add(frame(0))


def test_an_image_of_another_size_is_refused(tmp_path: Path) -> None:
    video = CameraVideo(tmp_path / "camera.mp4", 10.0)
    video.add(frame(0))

    with pytest.raises(ValueError, match="64"):
        video.add(np.zeros((10, 10, 3), dtype=np.uint8))
    video.close()
