"""A tick of the mission computer is complete with its frames, its image, and the camera that took it."""

from __future__ import annotations

import numpy as np

from mission_computer.input_assembler import IMAGES_MAX, PENDING_MAX, InputAssembler
from swarm_msgs_py.frames import Batch
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import FloatArray

INFO = CameraInfo(2, 2, np.eye(3), np.zeros(5))
ORDER = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])


def image(tick: int) -> CameraImage:
    return CameraImage(0.1 * tick, np.full((2, 2, 3), tick, dtype=np.uint8))


def batch(tick: int, parts: Parts = Parts.IMAGE) -> Batch:
    return Batch(tick, int(parts), (b"frame",))


def assembler(orders: list[FloatArray] | None = None) -> InputAssembler:
    waiting = [] if orders is None else orders
    return InputAssembler(0.1, lambda: waiting.pop() if waiting else None)


def test_without_a_camera_the_frames_are_all() -> None:
    inputs = assembler().put_batch(batch(3, Parts.NONE))

    assert inputs is not None
    assert (inputs.tick, inputs.inbox, inputs.image, inputs.camera) == (3, (b"frame",), None, None)


def test_frames_image_and_camera_may_come_in_any_order() -> None:
    for order in ("bic", "bci", "ibc", "icb", "cbi", "cib"):
        one, found = assembler(), []
        for what in order:
            put = {
                "b": lambda one=one: one.put_batch(batch(4)),
                "i": lambda one=one: one.put_image(4, image(4)),
                "c": lambda one=one: one.put_info(INFO),
            }[what]
            found.append(put())
        assert found[:2] == [None, None]
        assert found[2] is not None
        assert found[2].image is not None
        assert found[2].image.pixels[0, 0, 0] == 4
        assert found[2].camera is INFO


def test_a_tick_whose_image_was_lost_is_given_up_with_the_next() -> None:
    one = assembler()
    one.put_info(INFO)

    assert one.put_batch(batch(1)) is None
    assert one.put_batch(batch(2)) is None
    assert one.put_image(2, image(2)) is not None
    assert one.put_image(1, image(1)) is None


def test_a_tick_without_an_image_has_none_even_if_one_has_come_early() -> None:
    one = assembler()
    one.put_info(INFO)
    one.put_image(5, image(5))

    inputs = one.put_batch(batch(5, Parts.NONE))
    assert inputs is not None
    assert inputs.image is None


def test_an_order_goes_into_one_complete_tick() -> None:
    one = assembler([ORDER])
    one.put_info(INFO)
    one.put_batch(batch(1))

    first, second = one.put_image(1, image(1)), one.put_batch(batch(2, Parts.NONE))
    assert first is not None
    assert first.shape is ORDER
    assert second is not None
    assert second.shape is None


def test_what_never_gets_complete_does_not_pile_up() -> None:
    one = assembler()
    for tick in range(PENDING_MAX + 50):
        one.put_batch(batch(tick))
    for tick in range(IMAGES_MAX + 5):
        one.put_image(10_000 + tick, image(tick % 200))

    assert one.put_info(INFO) is None
    assert one.put_batch(batch(10_000)) is None  # its image was the oldest of too many
    assert one.put_batch(batch(10_000 + IMAGES_MAX + 4)) is not None
