"""Joins the messages of one tick, which arrive in any order, into one `MissionInputs`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from swarm_msgs_py.frames import Batch
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import FloatArray

IMAGES_MAX = 3
"""Images that are kept for a batch still to come; they are large."""

PENDING_MAX = 200
"""Batches that are kept for an image still to come; one that was lost never comes."""

T = TypeVar("T")
_IMAGE = int(Parts.IMAGE)


class InputAssembler:
    """Collects the parts of ticks; a tick is complete with its batch and the image that the batch announces.

    An image says nothing without the camera that took it, so what the maker says of that is waited for, too.

    Parameters
    ----------
    period_s : float
        Control period [s].
    take_order : callable
        Returns, once, the shape that the operator has ordered; called for every complete tick.
    """

    def __init__(self, period_s: float, take_order: Callable[[], FloatArray | None]) -> None:
        self._period, self._take_order = period_s, take_order
        self._batches: dict[int, Batch] = {}
        self._images: dict[int, CameraImage] = {}
        self._info: CameraInfo | None = None

    def put_batch(self, batch: Batch) -> MissionInputs | None:
        """Take the radio frames of a tick; return the inputs if they are complete now."""
        _keep(self._batches, batch.tick, batch, PENDING_MAX)
        return self._joined(batch.tick)

    def put_image(self, tick: int, image: CameraImage) -> MissionInputs | None:
        """Take the image of a tick; return the inputs if they are complete now."""
        _keep(self._images, tick, image, IMAGES_MAX)
        return self._joined(tick)

    def put_info(self, info: CameraInfo) -> MissionInputs | None:
        """Take what is known of the camera; return the inputs of the newest tick that waited for that, if one did."""
        self._info = info
        return self._joined(max(self._batches)) if self._batches else None

    def _joined(self, tick: int) -> MissionInputs | None:
        """Return the inputs of a tick and forget everything older if nothing is missing."""
        batch, image = self._batches.get(tick), self._images.get(tick)
        if batch is None:
            return None
        is_image_due = bool(batch.flags & _IMAGE)
        if is_image_due and (image is None or self._info is None):
            return None
        self._batches = {later: rest for later, rest in self._batches.items() if later > tick}
        self._images = {later: rest for later, rest in self._images.items() if later > tick}
        shown = image if is_image_due else None
        return MissionInputs(tick, tick * self._period, batch.frames, self._take_order(), shown, self._info)


def _keep(held: dict[int, T], tick: int, record: T, most: int) -> None:
    """Put a record among those that are held, and let the oldest go if that is too many."""
    held[tick] = record
    while len(held) > most:
        del held[min(held)]
