"""A tick's inputs are complete exactly when everything that its batch announces has come."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations

import numpy as np
import pytest

from swarm_agent.input_assembler import PENDING_MAX, InputAssembler
from swarm_msgs_py.frames import Batch
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.ros.formation_dialect import FORMATION
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.topics import Parts

PERIOD = 0.5
IMU = ImuSample(np.array([0.1, 0.2]), 0.3, 0.4)
FIX = PositionFix(np.array([1.0, 2.0]), 0.02)
SCAN = RangeScan(np.array([4]), np.array([5.0]))
POINTS = np.array([[0.5, 0.6]])
ALL = int(Parts.IMU | Parts.FIX | Parts.RANGES | Parts.PROXIMITY)
Put = Callable[[InputAssembler, int], AgentInputs | None]
PUTS: dict[str, Put] = {
    "imu": lambda a, tick: a.put(Parts.IMU, tick, IMU),
    "fix": lambda a, tick: a.put(Parts.FIX, tick, FIX),
    "ranges": lambda a, tick: a.put(Parts.RANGES, tick, SCAN),
    "proximity": lambda a, tick: a.put(Parts.PROXIMITY, tick, POINTS),
    "batch": lambda a, tick: a.put_batch(Batch(tick, ALL, (b"frame",))),
}


def assembler_of_a_robot() -> InputAssembler[AgentInputs]:
    return InputAssembler(PERIOD, FORMATION.join, FORMATION.required)


@pytest.mark.parametrize("order", list(permutations(PUTS))[::7], ids=lambda order: order[0])
def test_the_last_message_of_a_tick_completes_it_whatever_the_order(order: tuple[str, ...]) -> None:
    assembler = assembler_of_a_robot()

    *early, last = [PUTS[name](assembler, 6) for name in order]

    assert early == [None] * 4
    assert last is not None
    assert (last.tick, last.time) == (6, 3.0)
    assert (last.imu, last.fix, last.ranges, last.inbox) == (IMU, FIX, SCAN, (b"frame",))
    assert last.proximity is POINTS


def test_what_the_batch_does_not_announce_is_not_waited_for() -> None:
    assembler = assembler_of_a_robot()
    assembler.put_batch(Batch(0, int(Parts.IMU), ()))

    inputs = assembler.put(Parts.IMU, 0, IMU)

    assert inputs is not None
    assert inputs.fix is None
    assert inputs.proximity.shape == (0, 2)
    assert len(inputs.ranges.neighbors) == 0


def test_ticks_that_overlap_are_kept_apart() -> None:
    assembler = assembler_of_a_robot()
    for name in ("imu", "fix", "ranges", "proximity"):
        PUTS[name](assembler, 1)
        PUTS[name](assembler, 2)

    first, second = PUTS["batch"](assembler, 1), PUTS["batch"](assembler, 2)

    assert first is not None
    assert second is not None
    assert (first.tick, second.tick) == (1, 2)


def test_a_tick_of_which_a_part_is_lost_is_forgotten_with_the_next_complete_one() -> None:
    assembler = assembler_of_a_robot()
    for name in ("imu", "fix", "ranges"):
        PUTS[name](assembler, 1)
    for put in PUTS.values():
        put(assembler, 2)

    assert PUTS["proximity"](assembler, 1) is None
    assert PUTS["batch"](assembler, 1) is None


def test_unfinished_ticks_do_not_pile_up() -> None:
    assembler = assembler_of_a_robot()

    for tick in range(3 * PENDING_MAX):
        assembler.put(Parts.IMU, tick, IMU)

    assert len(assembler._pending) == PENDING_MAX
    assert max(assembler._pending) == 3 * PENDING_MAX - 1
