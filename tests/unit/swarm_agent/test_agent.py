"""The flow of one robot, by its inputs and outputs alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_agent, make_agent_inputs, make_plan, make_presence
from numpy.testing import assert_allclose

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_agent.energy import EnergyConfig
from swarm_msgs_py.body_codec import decode_body, encode_body
from swarm_msgs_py.frames import decode_frame
from swarm_msgs_py.messages.bodies import WEIGHT_ONE, CostRow, Plan, Report
from swarm_msgs_py.messages.control import STOP
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Hello, Packet
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.step_io import AgentOutputs
from swarm_msgs_py.types import MISSION, NodeId

GOAL = np.array([[3.0, 0.0]])


class Driver:
    """Moves one agent as its commands say, with the mission computer's radio beside it."""

    def __init__(self, agent: Agent, plan: Plan | None = None, yaw: float = 0.0) -> None:
        self.agent = agent
        self.position = np.zeros(2)
        self.yaw = yaw
        self.reports: list[Report] = []
        self._velocity = np.zeros(2)
        self._acceleration = np.zeros(2)
        self._tick = 0
        self._mission = MeshNetwork(MISSION, NetworkConfig(), PERIOD)
        self._inbox: tuple[bytes, ...] = ()
        self._to_mission: tuple[bytes, ...] = ()
        if plan is not None:
            self.order(plan)

    def order(self, plan: Plan) -> None:
        self._mission.flood(encode_body(plan))

    def step(self, **changes: object) -> AgentOutputs:
        cos, sin = np.cos(self.yaw), np.sin(self.yaw)
        to_world = np.array([[cos, -sin], [sin, cos]])
        inputs = make_agent_inputs(
            self._tick,
            imu=ImuSample(self._acceleration @ to_world, self.yaw, 0.0),
            fix=PositionFix(self.position, 0.02),
            inbox=self._inbox,
        )
        outputs = self.agent.step(replace(inputs, **changes))
        for delivery in self._mission.receive(self._tick, self._to_mission):
            body = decode_body(delivery.body)
            if isinstance(body, Report):
                self.reports.append(body)
        self._inbox = self._mission.transmit(
            self._tick, make_presence(sigma=0.0, robot_type=0, is_beacon=False, epoch=1)
        )
        self._to_mission = outputs.outbox
        velocity = to_world @ np.array([outputs.command.forward, outputs.command.left])
        self._acceleration = (velocity - self._velocity) / PERIOD
        self._velocity = velocity
        self.position = self.position + velocity * PERIOD
        self._tick += 1
        return outputs

    def run(self, seconds: float) -> AgentOutputs:
        for _ in range(round(seconds / PERIOD)):
            outputs = self.step()
        return outputs


def hello_of(outputs: AgentOutputs) -> Hello:
    (hello,) = [frame for frame in map(decode_frame, outputs.outbox) if isinstance(frame, Hello)]
    return hello


def rows_in(driver: Driver, ticks: int) -> list[CostRow]:
    """Return the cost rows that the robot sends of its own in the next ticks."""
    packets = [
        decode_body(frame.body)
        for _ in range(ticks)
        for frame in map(decode_frame, driver.step().outbox)
        if isinstance(frame, Packet) and frame.origin == 1
    ]
    return [body for body in packets if isinstance(body, CostRow)]


def test_equal_inputs_give_equal_outputs() -> None:
    one, other = Driver(make_agent(), make_plan(GOAL)), Driver(make_agent(), make_plan(GOAL))

    for _ in range(20):
        a, b = one.step(), other.step()
        assert a.command == b.command
        assert a.outbox == b.outbox


def test_without_a_position_a_robot_waits_and_says_so() -> None:
    outputs = make_agent().step(make_agent_inputs(fix=None))

    assert outputs.command == STOP
    assert outputs.report.mode is Mode.WAITING
    assert hello_of(outputs).presence.sigma == pytest.approx(SIGMA_UNKNOWN)


def test_a_robot_that_hears_no_plan_searches_for_the_mission_computer() -> None:
    driver = Driver(make_agent())
    driver.position = np.array([10.0, 0.0])

    outputs = driver.run(15.0)

    assert outputs.report.mode is Mode.SEARCHING
    assert driver.position[0] < 7.0


def test_drives_to_its_goal_and_parks() -> None:
    driver = Driver(make_agent(), make_plan(GOAL))

    outputs = driver.run(20.0)

    assert outputs.report.mode is Mode.PARKED
    assert outputs.report.goal == 0
    assert outputs.command == STOP
    assert_allclose(driver.position, GOAL[0], atol=0.1)


@pytest.mark.parametrize("yaw", [-3.0, -1.0, 0.5, 2.0])
def test_commands_are_in_the_body_frame(yaw: float) -> None:
    driver = Driver(make_agent(), make_plan(GOAL), yaw)

    driver.run(20.0)

    assert_allclose(driver.position, GOAL[0], atol=0.1)


def test_turns_back_to_heading_zero() -> None:
    assert make_agent().step(make_agent_inputs(imu=ImuSample(np.zeros(2), 1.0, 0.0))).command.yaw_rate < 0.0
    assert make_agent().step(make_agent_inputs(imu=ImuSample(np.zeros(2), -3.0, 0.0))).command.yaw_rate > 0.0


def test_never_exceeds_the_speed_limit() -> None:
    driver = Driver(make_agent(), make_plan(GOAL))
    limit = AgentConfig().control.speed_max_m_s

    commands = [driver.step().command for _ in range(40)]

    assert max(np.hypot(c.forward, c.left) for c in commands) <= limit + 1e-12


def test_floods_one_cost_row_per_plan() -> None:
    driver = Driver(make_agent(), make_plan(GOAL))

    (row,) = rows_in(driver, 10)

    assert row.costs.tolist() == [300]


def test_the_energy_that_driving_took_counts_in_the_row_of_the_next_plan() -> None:
    config = AgentConfig(energy=EnergyConfig(initial=0.9, per_meter=0.1))
    driver = Driver(Agent(NodeId(1), config, THESIS_TYPES[0], PERIOD), make_plan(GOAL))
    driver.run(20.0)
    driven = float(driver.position[0])
    driver.order(make_plan(2 * GOAL, epoch=2))

    rows = [row for row in rows_in(driver, 10) if row.epoch == 2]

    assert driven > 2.9
    assert rows[0].weight == pytest.approx(WEIGHT_ONE * (1.0 + 0.1 + 0.1 * driven), abs=3)


def test_acknowledges_the_plan_to_the_mission_computer() -> None:
    driver = Driver(make_agent(), make_plan(GOAL))

    driver.run(6.0)

    assert driver.reports
    assert driver.reports[-1].robot == NodeId(1)
    assert driver.reports[-1].epoch == 1


def test_a_robot_without_a_goal_of_its_type_stands_still() -> None:
    driver = Driver(make_agent(robot_type=2), make_plan(GOAL))

    outputs = driver.run(15.0)

    assert outputs.report.mode is Mode.UNASSIGNED
    assert_allclose(driver.position, [0.0, 0.0])


def test_keeps_going_where_the_old_plan_wanted_it_until_the_new_one_is_decided() -> None:
    agent, far = make_agent(), np.array([[30.0, 0.0]])
    driver = Driver(agent, make_plan(far))
    driver.run(5.0)
    driver._mission.flood(encode_body(make_plan(np.array([[30.0, 1.0], [0.0, 9.0]]), epoch=2)))  # two rows awaited

    outputs = driver.run(4.0)

    assert outputs.report.epoch == 2
    assert outputs.report.goal == -1
    assert outputs.command.forward > 0.4


def test_stops_for_what_it_would_drive_into() -> None:
    driver = Driver(make_agent(), make_plan(GOAL))
    driver.run(4.0)
    ring = 0.25 * np.column_stack([np.cos(np.linspace(0, 6, 12)), np.sin(np.linspace(0, 6, 12))])

    outputs = driver.step(proximity=ring)

    assert np.hypot(outputs.command.forward, outputs.command.left) < 0.05


def test_garbage_on_the_radio_is_counted_and_changes_nothing() -> None:
    clean, noisy = Driver(make_agent(), make_plan(GOAL)), Driver(make_agent(), make_plan(GOAL))

    for _ in range(20):
        good = clean.step()
        bad = noisy.step(inbox=(*noisy._inbox, b"", b"\x00" * 40, bytes(range(200))))

    assert bad.command == good.command
    assert bad.report.counters.corrupt == 60
