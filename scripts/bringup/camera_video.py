"""The video of what the camera saw and the mission computer read.

While a run goes on, images are appended to a file one by one, each a JPEG that is complete in itself: whatever dies,
all images up to then stay readable. An MP4 is made of them when the run is over; its index could only be written then.
"""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import cv2

from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.messages.camera import ImageArray

CODEC = "mp4v"
"""MPEG-4 Part 2: the FFmpeg that OpenCV's wheel brings along has no encoder of its own for H.264."""
QUALITY = 92
"""Of the JPEGs, of 100."""


class ImageStream:
    """Appends images to a file of JPEGs, one after the other.

    Parameters
    ----------
    path : Path
        ``*.mjpeg``; its folder must exist.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file: BinaryIO | None = None
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
        data = cv2.imencode(".jpg", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
        try:
            if self._file is None:
                self._size, self._file = size, self._path.open("wb", buffering=0)  # nothing is left in a buffer
            if size != self._size:
                raise ValueError(f"an image of {size} in a video of {self._size}")
            self._file.write(data.tobytes())
        except OSError as error:
            raise SwarmError(f"{self._path}: the film cannot be written ({error.strerror})") from None

    def close(self) -> None:
        """Close the file; may be called again. Without an image there is no file."""
        if self._file is not None:
            self._file.close()
            self._file = None


def make_video(stream: Path, path: Path, rate_hz: float) -> None:
    """Make an MP4 of a file of JPEGs, and remove that; without one there is no video.

    Parameters
    ----------
    stream : Path
        What `ImageStream` has written, complete or not.
    path : Path
        ``*.mp4``.
    rate_hz : float
        Images per second.

    Raises
    ------
    SwarmError
        If the video cannot be written; the images stay.
    """
    if not stream.exists():
        return
    images = cv2.VideoCapture(str(stream))
    is_read, image = images.read()
    if is_read:
        writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*CODEC), rate_hz, (image.shape[1], image.shape[0]))
        if not writer.isOpened():
            raise SwarmError(f"{path}: the video cannot be written; its images are in {stream.name}")
        while is_read:
            writer.write(image)
            is_read, image = images.read()
        writer.release()
    images.release()
    stream.unlink()
