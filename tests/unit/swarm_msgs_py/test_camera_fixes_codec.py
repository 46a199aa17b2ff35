"""Camera fixes and commanded headings on the air."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from builders import make_plan

from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.messages.bodies import CameraFixes, Plan
from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.types import NodeId

FIX = PoseFix(NodeId(3), np.array([0.25, -0.5]), -2.5, 0.000_504, 0.001_01)


def test_fixes_arrive_as_they_were_sent_and_no_more_certain() -> None:
    body = decode_body(encode_body(CameraFixes(70_000, (FIX, replace(FIX, robot=NodeId(4), yaw=math.pi)))))

    assert isinstance(body, CameraFixes)
    assert body.tick == 70_000
    assert [fix.robot for fix in body.fixes] == [3, 4]
    assert body.fixes[0].position.tolist() == [0.25, -0.5]
    assert body.fixes[1].yaw == pytest.approx(math.pi, abs=1e-6)
    assert 0.000_504 <= body.fixes[0].position_sigma < 0.000_515
    assert 0.001_01 <= body.fixes[0].yaw_sigma < 0.001_12


def test_five_fixes_are_short_enough_for_ten_broadcasts_a_second() -> None:
    assert len(encode_body(CameraFixes(0, (FIX,) * 5))) <= 100


def test_what_is_decoded_is_encoded_as_the_same_bytes() -> None:
    data = encode_body(CameraFixes(1, (FIX,)))

    assert encode_body(decode_body(data)) == data


@pytest.mark.parametrize(
    "change",
    [{"position": np.array([math.nan, 0.0])}, {"yaw": math.nan}, {"yaw": 7.0}, {"position": np.array([0.0, 2e6])}],
)
def test_what_is_no_place_or_heading_is_not_sent(change: dict[str, object]) -> None:
    with pytest.raises(FrameError):
        encode_body(CameraFixes(0, (replace(FIX, **change),)))  # type: ignore[arg-type]


@pytest.mark.parametrize("at", [-1, -3])
def test_a_fix_that_claims_to_be_exact_is_damaged(at: int) -> None:
    data = bytearray(encode_body(CameraFixes(0, (FIX,))))
    data[at - 1 : at + 1 or None] = b"\0\0"

    with pytest.raises(FrameError, match="without error"):
        decode_body(bytes(data))


def test_a_heading_out_of_range_is_damaged() -> None:
    data = bytearray(encode_body(CameraFixes(0, (FIX,))))
    data[-8:-4] = np.float32(40.0).tobytes()

    with pytest.raises(FrameError, match="heading"):
        decode_body(bytes(data))


@pytest.mark.parametrize("heading", [0.0, 1.25, -math.pi, math.pi])
def test_a_plan_says_which_way_to_face_in_two_bytes(heading: float) -> None:
    plan = make_plan(np.array([[1.0, 2.0]]))
    data = encode_body(replace(plan, heading=heading))
    found = decode_body(data)

    assert isinstance(found, Plan)
    assert found.heading == pytest.approx(heading, abs=6e-5)
    assert abs(found.heading or 0.0) <= math.pi
    assert len(data) == len(encode_body(plan)) + 2
    assert encode_body(found) == data


def test_a_plan_that_says_nothing_of_it_leaves_the_heading_to_the_robots() -> None:
    found = decode_body(encode_body(make_plan(np.array([[1.0, 2.0]]))))

    assert isinstance(found, Plan)
    assert found.heading is None


@pytest.mark.parametrize("heading", [math.nan, 3.2])
def test_a_plan_with_an_impossible_heading_is_not_sent(heading: float) -> None:
    with pytest.raises(FrameError, match="heading"):
        encode_body(replace(make_plan(np.array([[1.0, 2.0]])), heading=heading))
