"""The video of what the camera saw and the mission computer read: an MP4 in the run's folder."""

from __future__ import annotations

from pathlib import Path

import cv2

from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.messages.camera import ImageArray

CODEC = "mp4v"
"""MPEG-4 Part 2: the FFmpeg that OpenCV's wheel brings along has no encoder of its own for H.264."""


class CameraVideo:
    """Writes images to an MP4 file, one by one; it plays at the speed of the run's simulated time.

    Parameters
    ----------
    path : Path
        ``*.mp4``; its folder must exist.
    rate_hz : float
        Images per second of simulated time.
    """

    def __init__(self, path: Path, rate_hz: float) -> None:
        self._path, self._rate_hz = path, rate_hz
        self._writer: cv2.VideoWriter | None = None
        self._size = (0, 0)

    def add(self, pixels: ImageArray) -> None:
        """Append an image (h, w, 3), red, green, blue.

        Raises
        ------
        SwarmError
            If the file cannot be written.
        ValueError
            If the image has another size than the first one.
        """
        size = (pixels.shape[1], pixels.shape[0])
        if self._writer is None:
            self._size = size
            self._writer = cv2.VideoWriter(str(self._path), cv2.VideoWriter.fourcc(*CODEC), self._rate_hz, size)
            if not self._writer.isOpened():
                raise SwarmError(f"{self._path}: the video cannot be written; check that its folder takes files")
        if size != self._size:
            raise ValueError(f"an image of {size} in a video of {self._size}")
        self._writer.write(cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR))

    def close(self) -> None:
        """Finish the file; may be called again. Without an image there is no file."""
        if self._writer is not None:
            self._writer.release()
            self._writer = None
