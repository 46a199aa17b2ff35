"""The film of a run: every image of the camera, with what the mission computer read out of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from bringup.camera_video import CameraVideo
from bringup.engine import MissionActor
from swarm_msgs_py.step_io import MissionOutputs

FILM = "camera.mp4"
"""Its name in the folder of a run."""


@dataclass(frozen=True, slots=True)
class FilmOrder:
    """That a film is to be made.

    Attributes
    ----------
    path : Path
        Of the file.
    rate_hz : float
        Images per second.
    """

    path: Path
    rate_hz: float


class Film:
    """Takes down what the mission computer sees, in the process in which it runs: images are too large to send.

    Parameters
    ----------
    video : CameraVideo or None
        None: nothing is to be filmed.
    """

    def __init__(self, video: CameraVideo | None) -> None:
        self._video = video

    def take(self, mission: MissionActor, outputs: MissionOutputs) -> None:
        """Append the image of a tick, if there was one.

        Raises
        ------
        SwarmError
            If the file cannot be written.
        """
        if self._video is None or outputs.report.camera is None:
            return
        picture = mission.picture()
        if picture is not None:
            self._video.add(picture)


@contextmanager
def filming(order: FilmOrder | None) -> Iterator[Film]:
    """Yield the film that was ordered, and finish its file at the end."""
    video = None if order is None else CameraVideo(order.path, order.rate_hz)
    try:
        yield Film(video)
    finally:
        if video is not None:
            video.close()
