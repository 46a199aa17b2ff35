"""What one robot does with plans that name no goals, and when the plan in force changes the method."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, SQUARE, make_agent, make_agent_inputs, make_plan, make_presence

from swarm_agent.agent import Agent
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.frames import decode_frame, encode_frame
from swarm_msgs_py.messages.bodies import Body, CostRow, Plan, RowRequest, Task
from swarm_msgs_py.messages.control import STOP
from swarm_msgs_py.messages.radio import Hello, Packet, Presence, RouteRows
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.plan_goals import completed, goals_crc
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import AgentOutputs
from swarm_msgs_py.types import EVERYONE, FloatArray, NodeId

FORCES = [Task.FORCES, Task.FORCES_LITERAL]
ROSTER = Roster.of([THESIS_TYPES[0]] * 2)
WALL = np.array([[2.0, -1.0], [2.5, -1.0], [2.5, 1.0], [2.0, 1.0]])


def order(task: Task, epoch: int = 1, contour: FloatArray = SQUARE, crc: int | None = None) -> Plan:
    """Return a plan without goals for two small robots, with the right checksum unless told otherwise."""
    method = Method.VORONOI if task is Task.PARTITION else None
    nowhere, nobody = np.empty((0, 2)), np.empty(0, dtype=np.int64)
    plan = Plan(epoch, contour, (), nowhere, nobody, 0, task, ROSTER, method)
    if crc is None and task is Task.PARTITION:
        found = completed(plan, PartitionConfig())
        crc = goals_crc(found.goals, found.goal_types)
    return replace(plan, goals_crc=crc or 0)


class Field:
    """One robot that goes where it drives, and what it hears."""

    def __init__(self, x: float = 0.0, agent: Agent | None = None) -> None:
        self.agent = agent or make_agent(1)
        self.position = np.array([x, 0.0])
        self.tick = 0
        self.sent: list[object] = []
        self._velocity = np.zeros(2)
        self._imu = ImuSample(np.zeros(2), 0.0, 0.0)

    def step(self, *bodies: Body, contacts: FloatArray | None = None, near: Presence | None = None) -> AgentOutputs:
        own = RouteRows(np.array([7]), np.array([0]), np.array([2 * self.tick + 2]))
        presence = near or make_presence(0.0, 50.0, tick=self.tick, robot_type=0)
        inbox = [encode_frame(Hello(NodeId(7), self.tick, presence, own))]
        for body in bodies:
            names = self.tick, EVERYONE, NodeId(7), EVERYONE, self.tick * 4 + 1, 5
            inbox.append(encode_frame(Packet(NodeId(7), *names, encode_body(body))))
        proximity = np.empty((0, 2)) if contacts is None else contacts - self.position
        fix = PositionFix(self.position.copy(), 0.02)
        outputs = self.agent.step(
            make_agent_inputs(self.tick, imu=self._imu, fix=fix, proximity=proximity, inbox=tuple(inbox))
        )
        frames = [decode_frame(frame) for frame in outputs.outbox]
        self.sent += [decode_body(frame.body) for frame in frames if isinstance(frame, Packet)]
        velocity = np.array([outputs.command.forward, outputs.command.left])
        self._imu = ImuSample((velocity - self._velocity) / PERIOD, 0.0, 0.0)
        self._velocity = velocity
        self.position = self.position + PERIOD * velocity
        self.tick += 1
        return outputs

    def run(self, ticks: int) -> AgentOutputs:
        return [self.step() for _ in range(ticks)][-1]


def test_a_robot_finds_the_goals_by_itself_and_drives_to_one() -> None:
    field, plan = Field(-6.0), order(Task.PARTITION)
    outputs = field.step(plan)

    found = completed(plan, PartitionConfig())
    assert field.agent.plan is not None
    np.testing.assert_array_equal(field.agent.plan.goals, found.goals)
    assert outputs.report.goals_crc == plan.goals_crc != 0
    assert any(isinstance(body, CostRow) and len(body.costs) == 2 for body in field.sent)
    outputs = field.run(60)
    assert outputs.report.mode is Mode.PARKED
    assert np.linalg.norm(found.goals - field.position, axis=1).min() < 0.2


def test_who_asks_for_a_plan_is_given_the_order_not_the_goals() -> None:
    field, plan = Field(), order(Task.PARTITION)
    field.step(plan)
    field.sent.clear()

    field.step(RowRequest(0, ()))
    field.run(8)
    told = [body for body in field.sent if isinstance(body, Plan)]

    assert {encode_body(body) for body in told} == {encode_body(plan)}


def test_goals_that_differ_from_those_of_the_mission_computer_are_told_once(caplog: pytest.LogCaptureFixture) -> None:
    field, plan = Field(), order(Task.PARTITION, crc=5)
    with caplog.at_level(logging.WARNING):
        field.step(plan)
        field.step(plan)

    assert [record.getMessage() for record in caplog.records] == [
        "r01 finds other goals for plan 1 than the mission computer; give both the same settings and software"
    ]
    assert field.step().report.goals_crc not in {0, 5}


def test_a_shape_without_room_leaves_the_robot_where_it_is(caplog: pytest.LogCaptureFixture) -> None:
    field = Field(-1.0)
    with caplog.at_level(logging.WARNING):
        field.step(order(Task.PARTITION, contour=SQUARE * 0.05, crc=5))
    outputs = field.run(8)

    assert (outputs.report.epoch, outputs.report.goal, outputs.report.mode) == (1, -1, Mode.UNASSIGNED)
    assert outputs.command == STOP
    assert "r01 finds no goals for plan 1: a shape of" in caplog.text
    assert field.step(make_plan(SQUARE[:1], epoch=2)).report.epoch == 2


@pytest.mark.parametrize("task", [*FORCES, Task.PARTITION])
def test_a_plan_whose_contour_is_none_is_not_taken(task: Task) -> None:
    field = Field()
    field.step(make_plan(SQUARE[:1]))

    assert field.step(order(task, epoch=2, contour=SQUARE[::-1], crc=1)).report.epoch == 1


@pytest.mark.parametrize("task", FORCES)
def test_forces_drive_a_robot_into_the_shape_where_it_comes_to_rest(task: Task) -> None:
    field = Field(-9.0)
    outputs = field.step(order(task))
    assert outputs.report.mode is Mode.TRAVELING
    assert (outputs.report.goal, len(outputs.report.path)) == (-1, 0)
    outputs = field.run(100)

    assert outputs.report.mode is Mode.PARKED
    assert outputs.command == STOP
    assert np.abs(field.position).max() < 4.0
    assert not any(isinstance(body, CostRow) for body in field.sent)


@pytest.mark.parametrize("task", FORCES)
def test_what_stands_in_the_way_of_the_forces_is_not_run_into(task: Task) -> None:
    field = Field(-8.0)
    field.step(order(task))
    faces = np.column_stack([np.full(41, -5.0), np.linspace(-2.0, 2.0, 41)])  # on no map
    for _ in range(40):
        field.step(contacts=faces)
        assert np.linalg.norm(faces - field.position, axis=1).min() > 0.15
    assert field.position[0] > -6.5  # it came as far as it could, or got past


def test_the_plan_in_force_can_change_the_method_at_any_time() -> None:
    field = Field(-9.0)
    assert field.step(make_plan(np.array([[3.0, 0.0]]))).report.goal == 0
    assert field.step(order(Task.FORCES, epoch=2)).report.goal == -1
    assert field.run(60).report.mode is Mode.PARKED
    assert field.step(order(Task.FORCES_LITERAL, epoch=3)).report.epoch == 3

    field.step(make_plan(np.array([[3.0, 0.0]]), epoch=4))
    outputs = field.run(40)

    assert (outputs.report.goal, outputs.report.mode) == (0, Mode.PARKED)
    np.testing.assert_allclose(field.position, [3.0, 0.0], atol=0.1)


def test_forces_keep_robots_apart_by_what_the_plan_says_of_their_size() -> None:
    pushed = []
    for size in (0.15, 2.0):
        roster = Roster.of([THESIS_TYPES[0], replace(THESIS_TYPES[2], coverage_radius_m=size)])
        field = Field(0.0)
        plan = replace(order(Task.FORCES_LITERAL), roster=roster)
        field.step(plan)
        pushed.append(field.step(near=make_presence(2.5, 0.0, tick=1, robot_type=3)).command.forward)

    assert pushed[1] < pushed[0] < 0.0


def test_hello_of_a_force_driven_robot_asks_nobody_to_make_way() -> None:
    field = Field(-9.0)
    field.step(order(Task.FORCES))
    outputs = field.step()

    hello = next(decode_frame(frame) for frame in outputs.outbox)
    assert isinstance(hello, Hello)
    assert not hello.presence.asks_for_way
