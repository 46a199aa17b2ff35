"""The film of a run: every image of the camera, with what the mission computer read out of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import cv2

from bringup.camera_video import ImageStream, make_video
from bringup.engine import MissionActor
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.messages.camera import ImageArray
from swarm_msgs_py.step_io import MissionOutputs

FILM = "camera.mp4"
"""Its name in the folder of a run."""
RAW_SUFFIX = ".mjpeg"
"""Of what is written beside it while the run goes on."""
NO_IMAGE = "no image"
DIMMED = 3
"""How much darker a picture is that stands for one that is not there."""


@dataclass(frozen=True, slots=True)
class FilmOrder:
    """That a film is to be made.

    Attributes
    ----------
    path : Path
        Of the file.
    rate_hz : float
        Images per second.
    period_s : float
        Control period of the run [s].
    """

    path: Path
    rate_hz: float
    period_s: float

    @property
    def raw(self) -> Path:
        """Return the file that is written while the run goes on."""
        return self.path.with_suffix(RAW_SUFFIX)

    def due(self, tick: int) -> int:
        """Return how many pictures a film has that lasts up to a tick, that tick included."""
        return int(tick * self.period_s * self.rate_hz + 1e-6) + 1


class Film:
    """Takes down what the mission computer sees, in the process in which it runs: images are too large to send.

    It plays at the speed of simulated time: where the camera gave no image, the last picture is shown again, dimmed.

    Parameters
    ----------
    order : FilmOrder or None
        None: nothing is to be filmed.
    """

    def __init__(self, order: FilmOrder | None) -> None:
        self._order = order
        self._stream = None if order is None else ImageStream(order.raw)
        self._pictures = 0
        self._last: ImageArray | None = None

    def take(self, mission: MissionActor, outputs: MissionOutputs) -> None:
        """Append the image of a tick, if there was one, or what stands for it.

        Raises
        ------
        SwarmError
            If the file cannot be written.
        """
        if self._order is None or self._stream is None:
            return
        picture = mission.picture() if outputs.report.camera is not None else None
        like = picture if self._last is None else self._last
        missing = self._order.due(outputs.tick) - self._pictures - (picture is not None)
        if like is not None and missing > 0:
            card = _card(like)
            for _ in range(missing):
                self._stream.add(card)
            self._pictures += missing
        if picture is not None:
            self._stream.add(picture)
            self._pictures, self._last = self._pictures + 1, picture

    def close(self) -> None:
        """Close the file; may be called again."""
        if self._stream is not None:
            self._stream.close()


def _card(picture: ImageArray) -> ImageArray:
    """Return what is shown where there is no image: the last one, dimmed, and words that say so."""
    card = picture // DIMMED
    height, width = card.shape[:2]
    (wide, high), _ = cv2.getTextSize(NO_IMAGE, cv2.FONT_HERSHEY_SIMPLEX, 1.0, 2)
    place = ((width - wide) // 2, (height + high) // 2)
    cv2.putText(card, NO_IMAGE, place, cv2.FONT_HERSHEY_SIMPLEX, 1.0, (255, 255, 255), 2, cv2.LINE_AA)
    return card


@contextmanager
def filming(order: FilmOrder | None) -> Iterator[Film]:
    """Yield what takes the film that was ordered; `develop` makes it one that can be watched."""
    film = Film(order)
    try:
        yield film
    finally:
        film.close()


def develop(order: FilmOrder | None) -> tuple[str, ...]:
    """Make the film of what was taken down, also by a process that has died since; nobody may film any more.

    Returns
    -------
    tuple of str
        What the operator should read of it: why there is no film though there are images.
    """
    if order is None:
        return ()
    try:
        make_video(order.raw, order.path, order.rate_hz)
    except (SwarmError, OSError) as error:
        return (f"no film: {error}",)
    return ()
