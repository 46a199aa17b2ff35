from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.body_codec import BODY_MAX, row_size
from swarm_msgs_py.errors import FrameError
from swarm_msgs_py.frames import decode_body, decode_frame, encode_body, encode_frame
from swarm_msgs_py.messages.bodies import (
    UNREACHABLE,
    WEIGHT_MAX,
    WEIGHT_ONE,
    CostRow,
    Objective,
    Plan,
    Report,
    RowBundle,
    RowRequest,
    Task,
)
from swarm_msgs_py.messages.radio import Packet
from swarm_msgs_py.partition import Method
from swarm_msgs_py.plan_codec import ROBOTS_MAX
from swarm_msgs_py.roster import Roster, TypeGroup
from swarm_msgs_py.types import NodeId

TRIANGLE = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]])


def make_row(robot: int = 3, version: int = 2, costs: tuple[int, ...] = (120, UNREACHABLE)) -> CostRow:
    return CostRow(5, NodeId(robot), 2, version, np.array(costs, dtype=np.int64))


def row_with(objective: int = 0, weight: int = WEIGHT_ONE) -> bytes:
    """Return a row of robot 3 without costs, as no sender would make it."""
    return struct.pack("<BIHBHBHH", encode_body(make_row())[0], 5, 3, 2, 2, objective, weight, 0)


def make_plan() -> Plan:
    return Plan(9, TRIANGLE, (TRIANGLE + 10.0, TRIANGLE - 10.0), np.array([[1.0, 1.0], [0.5, 0.25]]), np.array([1, 3]))


ROSTER = Roster(
    groups=(
        TypeGroup(type=1, count=17, coverage_radius_m=0.15),
        TypeGroup(type=3, count=16, coverage_radius_m=0.5),
    )
)
NOWHERE, NOBODY = np.empty((0, 2)), np.empty(0, dtype=np.int64)


def make_order(task: Task = Task.PARTITION, **changes: object) -> Plan:
    """Return a plan that names no goals."""
    method, crc = (Method.VORONOI, 0xCAFE1234) if task is Task.PARTITION else (None, 0)
    plan = Plan(9, TRIANGLE, (TRIANGLE + 10.0,), NOWHERE, NOBODY, 1, task, ROSTER, method, crc)
    return replace(plan, **changes)  # type: ignore[arg-type]


def order_with(offset: int, layout: str, *values: int) -> bytes:
    """Return an order to partition with other bytes from `offset` on, counted from the end if it is negative."""
    data = bytearray(encode_body(make_order()))
    struct.pack_into(layout, data, offset % len(data), *values)
    return bytes(data)


@pytest.mark.parametrize("task", [task for task in Task if task is not Task.GOALS])
def test_a_plan_without_goals_says_what_to_do_and_for_whom(task: Task) -> None:
    sent = make_order(task)

    heard = decode_body(encode_body(sent))

    assert isinstance(heard, Plan)
    assert (heard.task, heard.roster, heard.method, heard.goals_crc) == (task, ROSTER, sent.method, sent.goals_crc)
    assert (heard.goals.shape, heard.goal_types.shape, heard.robot_count) == ((0, 2), (0,), 33)
    assert_allclose(heard.body_outlines[0], TRIANGLE + 10.0)


def test_goals_that_robots_found_for_themselves_do_not_go_on_the_air() -> None:
    found = make_order(goals=np.array([[1.0, 1.0]]), goal_types=np.array([1]))

    assert encode_body(found) == encode_body(make_order())


def test_an_order_is_far_shorter_than_the_goals_that_follow_from_it() -> None:
    goals = replace(make_plan(), goals=np.zeros((50, 2)), goal_types=np.ones(50, dtype=np.int64))

    assert len(encode_body(make_order())) == 1 + 20 + 12 + 2 + 12 + 1 + 2 * 5 + 5
    assert len(encode_body(make_order())) < 0.25 * len(encode_body(goals))


def test_nobody_is_larger_than_an_order_says() -> None:
    odd = Roster(groups=(TypeGroup(type=1, count=1, coverage_radius_m=0.12345),))

    heard = decode_body(encode_body(make_order(roster=odd)))

    assert isinstance(heard, Plan)
    assert heard.roster is not None
    assert heard.roster.groups[0].coverage_radius_m == 0.124
    assert encode_body(heard) == encode_body(make_order(roster=odd))


def test_plan_survives_the_air() -> None:
    decoded = decode_body(encode_body(make_plan()))

    assert isinstance(decoded, Plan)
    assert decoded.epoch == 9
    assert_allclose(decoded.contour, TRIANGLE)
    assert len(decoded.obstacles) == 2
    assert_allclose(decoded.obstacles[1], TRIANGLE - 10.0)
    assert_allclose(decoded.goals, [[1.0, 1.0], [0.5, 0.25]])
    assert_array_equal(decoded.goal_types, [1, 3])


def test_plan_without_obstacles_and_goals_keeps_its_array_shapes() -> None:
    decoded = decode_body(encode_body(Plan(1, TRIANGLE, (), np.zeros((0, 2)), np.zeros(0, dtype=np.int64))))

    assert isinstance(decoded, Plan)
    assert decoded.obstacles == ()
    assert decoded.goals.shape == (0, 2)
    assert decoded.goal_types.shape == (0,)


def test_cost_row_survives_the_air() -> None:
    decoded = decode_body(encode_body(make_row()))

    assert isinstance(decoded, CostRow)
    assert (decoded.epoch, decoded.robot, decoded.robot_type, decoded.version) == (5, 3, 2, 2)
    assert_array_equal(decoded.costs, [120, UNREACHABLE])


@pytest.mark.parametrize("objective", list(Objective))
@pytest.mark.parametrize("weight", [1, WEIGHT_ONE, WEIGHT_MAX])
def test_weight_and_objective_of_a_row_survive_the_air(weight: int, objective: Objective) -> None:
    row = replace(make_row(), weight=weight, objective=objective)

    alone, bundled = decode_body(encode_body(row)), decode_body(encode_body(RowBundle((make_row(), row))))

    assert isinstance(alone, CostRow)
    assert (alone.weight, alone.objective) == (weight, objective)
    assert isinstance(bundled, RowBundle)
    assert (bundled.rows[1].weight, bundled.rows[1].objective) == (weight, objective)
    assert (bundled.rows[0].weight, bundled.rows[0].objective) == (WEIGHT_ONE, Objective.TOTAL)


def test_a_row_is_15_bytes_and_2_for_each_goal() -> None:
    assert len(encode_body(make_row(costs=(1, 2, 3)))) == 15 + 3 * 2


def test_withdrawn_row_is_empty() -> None:
    decoded = decode_body(encode_body(make_row(costs=())))

    assert isinstance(decoded, CostRow)
    assert decoded.costs.shape == (0,)


def test_row_request_survives_the_air() -> None:
    request = RowRequest(5, ((NodeId(0), 1), (NodeId(49), 65535)))

    assert decode_body(encode_body(request)) == request


def test_row_bundle_survives_the_air() -> None:
    decoded = decode_body(encode_body(RowBundle((make_row(1), make_row(2, 7, (5,))))))

    assert isinstance(decoded, RowBundle)
    assert [(row.robot, row.version, row.costs.tolist()) for row in decoded.rows] == [
        (1, 2, [120, UNREACHABLE]),
        (2, 7, [5]),
    ]


@pytest.mark.parametrize("goal", [-1, 0, 49])
def test_report_survives_the_air(goal: int) -> None:
    report = Report(NodeId(4), 1, 70000, goal, (1.5, -2.5), 3, 0.25)

    assert decode_body(encode_body(report)) == report


@pytest.mark.parametrize(("sigma", "heard"), [(0.0, 0.0), (0.231, 0.24), (0.24, 0.24), (1e4, 655.35), (np.inf, 655.35)])
def test_nobody_thinks_a_reported_place_more_certain_than_it_is(sigma: float, heard: float) -> None:
    report = decode_body(encode_body(Report(NodeId(4), 1, 1, 0, (0.0, 0.0), 3, sigma)))

    assert isinstance(report, Report)
    assert report.sigma == pytest.approx(heard)
    assert decode_body(encode_body(report)) == report


def test_a_plan_tells_bodies_from_walls() -> None:
    wall, body = TRIANGLE + 10.0, TRIANGLE - 10.0

    for bodies, walls in ((0, 2), (1, 1), (2, 0)):
        plan = decode_body(encode_body(replace(make_plan(), obstacles=(wall, body), bodies=bodies)))
        assert isinstance(plan, Plan)
        assert [len(plan.walls), len(plan.body_outlines)] == [walls, bodies]
        assert_array_equal(np.concatenate([*plan.walls, *plan.body_outlines]), np.concatenate([wall, body]))


def test_a_plan_with_more_bodies_than_obstacles_is_refused() -> None:
    data = bytearray(encode_body(make_plan()))
    struct.pack_into("<H", data, 1 + 4 + 2 + 2, 3)  # after kind, epoch, contour, obstacles

    with pytest.raises(FrameError, match="3 bodies among 2 obstacles"):
        decode_body(bytes(data))


def test_receivers_share_one_read_only_record() -> None:
    data = encode_body(make_plan())
    first = decode_body(data)

    assert decode_body(bytes(bytearray(data))) is first
    assert isinstance(first, Plan)
    assert not any(a.flags.writeable for a in (first.contour, first.goals, first.goal_types, *first.obstacles))


@pytest.mark.parametrize(
    "body",
    [
        make_row(costs=(-1,)),
        make_row(costs=(65536,)),
        make_row(version=65536),
        replace(make_row(), weight=0),
        replace(make_row(), weight=WEIGHT_MAX + 1),
        Report(NodeId(1), 1, 1, 0, (float("nan"), 0.0), 0, 0.1),
        Report(NodeId(1), 1, 1, 40000, (0.0, 0.0), 0, 0.1),
        Plan(1, np.full((3, 2), np.inf), (), TRIANGLE, np.array([1, 1, 1])),
        Plan(1, TRIANGLE, (), TRIANGLE, np.array([1])),
        Plan(1, TRIANGLE, (TRIANGLE,), TRIANGLE, np.array([1, 1, 1]), 2),
        Plan(1, TRIANGLE, (TRIANGLE,), TRIANGLE, np.array([1, 1, 1]), -1),
        Plan(1, TRIANGLE, (), TRIANGLE, np.array([1, 1, 256])),
        make_order(roster=None),
        make_order(Task.FORCES, roster=None),
        make_order(method=None),
        make_order(goals_crc=-1),
        make_order(roster=Roster(groups=(TypeGroup(type=1, count=1, coverage_radius_m=66.0),))),
        make_order(roster=Roster(groups=tuple(replace(g, count=ROBOTS_MAX // 2 + 1) for g in ROSTER.groups))),
    ],
    ids=[
        "negative cost",
        "cost",
        "version",
        "no weight",
        "weight",
        "nan",
        "goal",
        "infinite contour",
        "types missing",
        "too many bodies",
        "negative bodies",
        "type",
        "no roster",
        "no roster for forces",
        "no method",
        "checksum",
        "giant",
        "crowd",
    ],
)
def test_sender_cannot_encode_nonsense(body: CostRow | Report | Plan) -> None:
    with pytest.raises(FrameError):
        encode_body(body)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "ends early"),
        (b"\x63", "unknown kind"),
        (encode_body(make_row()) + b"\x00", "1 bytes too many"),
        (encode_body(make_row())[:-1], "ends early"),
        (row_with(objective=len(Objective)), "unknown objective: 2"),
        (row_with(weight=0), "weight 0"),
        (encode_body(Report(NodeId(1), 1, 1, 0, (0.0, 0.0), 0, 0.1))[:-7] + b"\x00\x00\xc0\x7f\x00\x0a\x00", "finite"),
        (order_with(11, "<B", len(Task)), "unknown task: 4"),
        (order_with(-5, "<B", len(Method)), "unknown partition method: 3"),
        (order_with(-10, "<BHH", 3, 0, 500), "a roster that is none: count must be >= 1"),
        (order_with(-10, "<BHH", 0, 16, 500), "a roster that is none: type must be >= 1"),
        (order_with(-10, "<BHH", 3, 16, 0), "a roster that is none: coverage_radius_m must be > 0"),
        (order_with(-10, "<BHH", 1, 16, 500), "lists robot type 1 2 times"),
        (order_with(-10, "<BHH", 3, 984, 500), "a roster of 1001 robots"),
        (order_with(-16, "<B", 0)[:-10], "a roster that is none|too many"),
    ],
    ids=[
        *("empty", "kind", "long", "short", "objective", "weight", "nan"),
        *("task", "method", "no robots", "no type", "no size", "twice", "crowd", "nobody"),
    ],
)
def test_receiver_names_what_is_wrong(data: bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        decode_body(data)


def test_a_plan_too_large_for_a_packet_is_refused_with_its_size_and_what_to_reduce() -> None:
    goals, contour = np.zeros((ROBOTS_MAX, 2)), np.zeros((16000, 2))
    plan = Plan(1, contour, (TRIANGLE,), goals, np.ones(ROBOTS_MAX, dtype=np.int64))

    with pytest.raises(FrameError) as caught:
        encode_body(plan)

    text = str(caught.value)
    size = 1 + 22 + 16000 * 4 + 2 + 12 + ROBOTS_MAX * 5
    assert f"Plan of {size} bytes; a packet carries at most {BODY_MAX}" in text
    assert "1000 goals of 5 bytes, 16000 contour points of 4, and 1 obstacles with 3 corners of 4: use fewer" in text
    assert "\n" not in text


@pytest.mark.parametrize(
    "body",
    [
        make_row(costs=(1,) * 40_000),
        RowBundle((make_row(costs=(1,) * 1000),) * 40),
        RowRequest(1, ((NodeId(1), 1),) * 20_000),
        Plan(1, np.zeros((70_000, 2)), (), TRIANGLE, np.ones(3, dtype=np.int64)),
    ],
    ids=["row", "bundle", "request", "contour"],
)
def test_no_body_is_longer_than_a_packet_carries(body: CostRow | RowBundle | RowRequest | Plan) -> None:
    with pytest.raises(FrameError):
        encode_body(body)


def test_the_longest_body_survives_the_air() -> None:
    count = (BODY_MAX - len(encode_body(make_row(costs=())))) // 2
    data = encode_body(make_row(costs=(7,) * count))

    assert BODY_MAX - 1 <= len(data) <= BODY_MAX
    assert decode_frame(encode_frame(Packet(*(NodeId(1),) * 5, 1, 1, data))).body == data  # type: ignore[union-attr]


def test_the_size_of_a_row_is_what_it_adds_to_a_bundle() -> None:
    row = make_row(costs=(1, 2, 3))

    assert row_size(row) == len(encode_body(RowBundle((row, row)))) - len(encode_body(RowBundle((row,))))


@pytest.mark.parametrize("x", [2e6, -1e30, float("inf"), float("nan")])
def test_absurd_coordinates_are_refused_on_both_ends(x: float) -> None:
    far = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, x]])
    near = encode_body(Report(NodeId(1), 1, 1, 0, (0.0, 0.0), 0, 0.1))

    for body in (Plan(1, far, (), TRIANGLE, np.ones(3, dtype=np.int64)), Report(NodeId(1), 1, 1, 0, (0.0, x), 0, 0.1)):
        with pytest.raises(FrameError, match="not finite, or beyond"):
            encode_body(body)
    with pytest.raises(FrameError, match="not finite, or beyond"):
        decode_body(near[:-7] + struct.pack("<f", x) + near[-3:])
