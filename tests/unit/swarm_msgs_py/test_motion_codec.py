"""Plans whose shape moves, as bytes."""

from __future__ import annotations

import gc
import struct
import weakref
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from swarm_msgs_py import motion_codec, plan_codec
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.bodies import Motion, Plan, Task
from swarm_msgs_py.partition import Method
from swarm_msgs_py.roster import Roster, TypeGroup
from swarm_msgs_py.types import FloatArray

TRIANGLE = np.array([[0.0, 0.0], [9.0, 0.0], [0.0, 9.0]])
SMALL, LARGE = (TypeGroup(type=t, count=3 - t, coverage_radius_m=0.2 * t) for t in (1, 2))
ROSTER = Roster(groups=(SMALL, LARGE))
TYPES = np.array([1, 2, 1])
HEAD = 4 + 4 + 4 + 8 + 2 + 1


def smooth_track(count: int, knots: int, reach: float) -> FloatArray:
    """Return goals that go `reach` to the right by smooth steps, the first of them at rest."""
    share = np.linspace(0.0, 1.0, knots)[:, None]
    ways = reach * np.arange(count) / (count - 1)
    x = 0.5 * np.arange(count) + (share**2 * (3.0 - 2.0 * share)) * ways
    return np.stack([x, np.broadcast_to(np.arange(count) * 0.25, x.shape)], axis=2).round(2)


def moving(track: FloatArray, types: np.ndarray, **changes: object) -> Plan:
    motion = Motion(120, 80, TRIANGLE - 1.0, 1.5, track, len(track))
    plan = Plan(7, TRIANGLE, (TRIANGLE + 20.0,), track[-1], types, 1, motion=motion, follows=6)
    return replace(plan, **changes)  # type: ignore[arg-type]


def heard(plan: Plan) -> tuple[Plan, Motion]:
    received = decode_body(encode_body(plan))
    assert isinstance(received, Plan)
    assert received.motion is not None
    return received, received.motion


def test_a_motion_arrives_to_the_centimeter() -> None:
    sent = moving(smooth_track(3, 8, 6.0), TYPES)

    plan, motion = heard(sent)

    assert (plan.epoch, plan.follows, plan.task) == (7, 6, Task.GOALS)
    assert (motion.begins, motion.ticks, motion.rotation_rad, motion.knots, motion.ends) == (120, 80, 1.5, 8, 200)
    assert_array_equal(motion.start.round(9), TRIANGLE - 1.0)
    assert_array_equal(motion.track.round(9), smooth_track(3, 8, 6.0))
    assert_array_equal(motion.track[-1], plan.goals)
    assert not motion.track.flags.writeable
    assert encode_body(plan) == encode_body(sent)


def test_fifty_robots_and_twelve_knots_take_thirteen_hundred_bytes() -> None:
    sent = moving(smooth_track(50, 12, 15.0), np.ones(50, dtype=np.int64))
    still = replace(sent, motion=None)

    extra = len(encode_body(sent)) - len(encode_body(still))

    assert extra == HEAD + 3 * 4 + 13 + 49 * 11 * 2
    assert len(encode_body(still)) == len(encode_body(replace(still, follows=6)))


def test_goals_at_rest_cost_a_quarter_of_a_byte() -> None:
    track = np.broadcast_to(smooth_track(40, 2, 0.0)[0], (30, 40, 2))

    extra = len(encode_body(moving(track, np.ones(40, dtype=np.int64)))) - len(
        encode_body(moving(track, np.ones(40, dtype=np.int64), motion=None))
    )

    assert extra == HEAD + 3 * 4 + 40 // 4


def test_a_jump_takes_two_bytes_for_that_goal_alone() -> None:
    track = smooth_track(3, 8, 6.0)
    size = len(encode_body(moving(track, TYPES)))
    track[4, 1] += [1.5, 0.0]

    plan, motion = heard(moving(track, TYPES))

    assert_array_equal(motion.track.round(9), track.round(9))
    assert len(encode_body(plan)) == size + 7 * 2


def test_a_plan_to_partition_tells_only_where_goals_begin() -> None:
    start = smooth_track(3, 2, 0.0)[:1]
    motion = Motion(120, 80, TRIANGLE - 1.0, 0.0, start, 13)
    order = Plan(7, TRIANGLE, (), start[0], TYPES, 0, Task.PARTITION, ROSTER, Method.VORONOI, 5, motion, 6)

    plan, held = heard(order)

    assert_array_equal(plan.goals.round(9), start[0])
    assert_array_equal(plan.goal_types, TYPES)
    assert (held.track.shape, held.knots, plan.goals_crc) == ((1, 3, 2), 13, 5)
    assert encode_body(plan) == encode_body(order)


def test_what_a_robot_has_completed_it_passes_on_as_it_came() -> None:
    track = smooth_track(3, 13, 4.0)
    motion = Motion(120, 80, TRIANGLE, 0.0, track, 13)
    whole = Plan(7, TRIANGLE, (), track[-1], TYPES, 0, Task.PARTITION, ROSTER, Method.VORONOI, 5, motion, 6)
    bare = replace(whole, goals=track[0], motion=replace(motion, track=track[:1]))

    assert encode_body(whole) == encode_body(bare)


@pytest.mark.parametrize("task", [Task.FORCES, Task.FORCES_LITERAL])
def test_forces_need_the_contours_alone(task: Task) -> None:
    nowhere, nobody = np.empty((0, 2)), np.empty(0, dtype=np.int64)
    motion = Motion(1, 2, TRIANGLE - 1.0, 0.0, np.empty((0, 0, 2)), 8)
    order = Plan(7, TRIANGLE, (), nowhere, nobody, 0, task, ROSTER, motion=motion)

    _, held = heard(order)

    assert len(encode_body(order)) - len(encode_body(replace(order, motion=None))) == HEAD + 3 * 4
    assert held.track.size == 0
    assert_array_equal(held.start.round(9), TRIANGLE - 1.0)


TRACK = smooth_track(3, 8, 6.0)


@pytest.mark.parametrize(
    ("plan", "reason"),
    [
        (moving(TRACK, TYPES, goals=TRACK[0]), "does not lead to the 3 goals"),
        (moving(TRACK, TYPES, motion=Motion(1, 2, TRIANGLE, 0.0, TRACK, 9)), "does not lead to the 3 goals"),
        (moving(TRACK, TYPES, motion=Motion(1, 0, TRIANGLE, 0.0, TRACK, 8)), "0 ticks"),
        (moving(TRACK[:1], TYPES), "1 knots"),
        (moving(TRACK, TYPES, motion=Motion(1, 2, TRIANGLE, np.nan, TRACK, 8)), "turns by nan"),
        (moving(TRACK, TYPES, motion=Motion(1, 2, TRIANGLE, 1e9, TRACK, 8)), "turns by 1e"),
        (moving(TRACK, TYPES, motion=Motion(1, 2, TRIANGLE + np.inf, 0.0, TRACK, 8)), "not finite"),
        (moving(TRACK, TYPES, motion=Motion(-1, 2, TRIANGLE, 0.0, TRACK, 8)), "does not fit"),
        (moving(TRACK, TYPES, task=Task.PARTITION, roster=ROSTER, method=Method.VORONOI,
                motion=Motion(1, 2, TRIANGLE, 0.0, np.empty((0, 3, 2)), 8)), "without the goals"),
    ],
)  # fmt: skip
def test_a_motion_that_makes_no_sense_is_not_sent(plan: Plan, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        encode_body(plan)


def many(count: int) -> FloatArray:
    """Return a contour of so many corners."""
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return 50.0 * np.column_stack([np.cos(angles), np.sin(angles)])


def crowd(count: int, knots: int) -> Plan:
    """Return a plan that leaves so many robots to find so many knots."""
    roster = Roster(groups=(replace(SMALL, count=count),))
    start = np.zeros((1, count, 2))
    motion = Motion(1, 2000, TRIANGLE, 0.0, start, knots)
    types = np.full(count, SMALL.type)
    return Plan(7, TRIANGLE, (), start[0], types, 0, Task.PARTITION, roster, Method.VORONOI, 5, motion, 6)


@pytest.mark.parametrize(
    ("plan", "reason"),
    [
        (moving(smooth_track(3, 65, 1.0), TYPES), "65 knots"),
        (moving(TRACK, TYPES, motion=Motion(1, 2, many(513), 0.0, TRACK, 8)), "513 corners cannot move"),
        (moving(TRACK, TYPES, contour=many(513)), "513 corners cannot move"),
        (moving(smooth_track(1001, 2, 0.0), np.ones(1001, dtype=np.int64)), "1001 goals; the air carries at most 1000"),
        (crowd(51, 64), "51 robots over 64 knots; robots find 62 for so many"),
    ],
)
def test_a_motion_that_would_keep_robots_busy_is_neither_sent_nor_taken(
    plan: Plan, reason: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(FrameError, match=reason):
        encode_body(plan)
    with monkeypatch.context() as forger:
        for module, limit in ((motion_codec, "KNOTS_MAX"), (motion_codec, "CORNERS_MAX"), (motion_codec, "FOUND_MAX"),
                              (plan_codec, "ROBOTS_MAX")):  # fmt: skip
            forger.setattr(module, limit, 10**9)
        data = encode_body(plan)
    with pytest.raises(FrameError, match=reason):
        decode_body(data)


def test_fifty_robots_may_find_as_many_knots_as_there_can_be() -> None:
    assert heard(crowd(50, 64))[1].knots == 64


def test_plans_are_held_no_longer_than_until_some_others_came() -> None:
    held = weakref.ref(heard(moving(TRACK, TYPES))[1].track)

    for epoch in range(20):
        decode_body(encode_body(moving(TRACK, TYPES, epoch=100 + epoch)))

    gc.collect()
    assert held() is None


def test_a_forged_motion_is_told_from_a_real_one() -> None:
    start = smooth_track(3, 2, 0.0)[:1]
    motion = Motion(120, 80, TRIANGLE, 0.0, start, 13)
    order = Plan(7, TRIANGLE, (), start[0], TYPES, 0, Task.PARTITION, ROSTER, Method.VORONOI, 5, motion, 6)
    data = bytearray(encode_body(order))

    with pytest.raises(FrameError, match="for other robots"):
        decode_body(bytes(data[:-1]) + b"\x02")
    for size in range(len(data)):
        with pytest.raises(FrameError):
            decode_body(bytes(data[:size]))
    struct.pack_into("<I", data, len(data) - 3 * 5 - 12 - HEAD + 8, 0)
    with pytest.raises(FrameError, match="a motion of 0 ticks"):
        decode_body(bytes(data))
