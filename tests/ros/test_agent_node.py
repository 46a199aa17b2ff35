"""A robot's node answers as its core does, stays in its namespace, and shows itself to those who look."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np
import pytest
from builders import make_agent, make_agent_inputs
from ros_harness import RosHarness, harness

from swarm_agent.ros.agent_node import AgentNode, _from_parameters
from swarm_msgs_py import topics
from swarm_msgs_py.frames import decode_frame, pack_batch, unpack_batch
from swarm_msgs_py.messages.radio import SIGMA_UNKNOWN, Hello
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.ros import cdr, convert
from swarm_msgs_py.step_io import AgentInputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import NodeId

ROBOT = NodeId(1)
PERIOD = 0.5
FRAME = convert.body_frame(ROBOT)
ALL_PARTS = Parts.IMU | Parts.FIX | Parts.RANGES | Parts.PROXIMITY


@pytest.fixture
def ros(domain_id: int) -> Iterator[RosHarness]:
    assert domain_id
    with harness() as ready:
        yield ready


def senses(inputs: AgentInputs) -> list[tuple[topics.Channel, bytes]]:
    stamp = cdr.stamp(inputs.time)
    assert inputs.fix is not None
    return [
        (topics.IMU, convert.encode_imu(stamp, FRAME, inputs.imu)),
        (topics.FIX, convert.encode_fix(stamp, inputs.fix)),
        (topics.RANGES, convert.encode_ranges(inputs.tick, inputs.ranges)),
        (topics.PROXIMITY, convert.encode_proximity(stamp, FRAME, inputs.proximity)),
        (topics.RADIO_RX, convert.encode_batch(pack_batch(inputs.tick, ALL_PARTS, inputs.inbox))),
    ]


def test_the_node_answers_every_tick_exactly_as_the_core_does_in_whatever_order_messages_come(ros: RosHarness) -> None:
    ros.add(AgentNode(make_agent(ROBOT), ROBOT, PERIOD, context=ros.context))
    core = make_agent(ROBOT)
    speakers = {channel: ros.speaker(channel, ROBOT) for channel in topics.ROBOT_SENSORS}
    commands = ros.listen(topics.CMD_VEL, ROBOT, raw=True)
    batches = ros.listen(topics.RADIO_TX, ROBOT, raw=True)
    rng = np.random.default_rng(3)

    for tick, order in enumerate(list(permutations(range(5)))[::17]):
        inputs = make_agent_inputs(
            tick,
            proximity=rng.normal(size=(3, 2)),
            ranges=RangeScan(np.array([2, 7]), rng.uniform(1, 9, 2)),
            inbox=(b"noise",),
        )
        expected = core.step(inputs)
        messages = senses(inputs)
        for number in order:
            channel, data = messages[number]
            speakers[channel].publish(data)
        ros.wait(lambda n=tick + 1: len(commands) == n and len(batches) == n, "an answer")  # type: ignore[misc]

        stamped, command = convert.decode_command(commands[-1])
        batch = unpack_batch(convert.decode_batch(batches[-1]))
        assert (stamped, command) == (inputs.time, expected.command)
        assert (batch.tick, batch.frames) == (tick, expected.outbox)


def test_a_robot_without_a_position_sensor_answers_without_waiting_for_a_fix(ros: RosHarness) -> None:
    ros.add(AgentNode(make_agent(ROBOT), ROBOT, PERIOD, context=ros.context))
    commands = ros.listen(topics.CMD_VEL, ROBOT)
    without = [entry for entry in senses(make_agent_inputs(0)) if entry[0] is not topics.FIX]
    without[-1] = (topics.RADIO_RX, convert.encode_batch(pack_batch(0, ALL_PARTS & ~Parts.FIX, ())))

    for channel, data in without:
        ros.speaker(channel, ROBOT).publish(data)

    ros.wait(lambda: len(commands) == 1, "an answer")


def test_a_message_that_is_not_what_it_claims_is_dropped_and_the_node_goes_on(ros: RosHarness) -> None:
    ros.add(AgentNode(make_agent(ROBOT), ROBOT, PERIOD, context=ros.context))
    commands = ros.listen(topics.CMD_VEL, ROBOT)
    ros.speaker(topics.RADIO_RX, ROBOT).publish(convert.encode_batch(b"not a batch"))
    ros.speaker(topics.RANGES, ROBOT).publish(cdr.byte_array(b"not a table"))

    for channel, data in senses(make_agent_inputs(0)):
        ros.speaker(channel, ROBOT).publish(data)

    ros.wait(lambda: len(commands) == 1, "an answer")


def test_viewers_see_the_estimate_the_path_and_the_state(ros: RosHarness) -> None:
    ros.add(AgentNode(make_agent(ROBOT), ROBOT, PERIOD, context=ros.context))
    odoms, paths, states = (ros.listen(channel, ROBOT) for channel in topics.ROBOT_VIEWS)
    speakers = [(ros.speaker(channel, ROBOT), channel) for channel in topics.ROBOT_SENSORS]
    ros.wait(lambda: all(ros.probe.count_publishers(c.topic(ROBOT)) for c in topics.ROBOT_VIEWS), "the views")
    ticks = iter(range(10_000))

    def seen() -> bool:
        messages = dict(senses(make_agent_inputs(next(ticks))))
        for speaker, channel in speakers:
            speaker.publish(messages[channel])
        return bool(odoms and paths and states)

    ros.wait(seen, "odometry, path and status")
    assert odoms[0].child_frame_id == "r01/base_link"
    assert odoms[0].pose.covariance[0] > 0.0
    assert paths[0].header.frame_id == "map"
    shown = {entry.key: entry.value for entry in states[0].status[0].values}
    assert shown.keys() >= {"mode", "goal", "neighbors", "frames_sent", "lost_by_beacons", "lost_by_sigma"}
    assert shown["positioning"] == "localized"
    assert float(shown["position_sigma_m"]) < 0.1


def first_answer(ros: RosHarness, robot: NodeId) -> tuple[Hello, dict[str, str]]:
    """Return the first hello of a robot without a position sensor, and what its first status shows."""
    batches, states = ros.listen(topics.RADIO_TX, robot, raw=True), ros.listen(topics.STATUS, robot)
    speakers = {channel: ros.speaker(channel, robot) for channel in topics.ROBOT_SENSORS}
    ros.wait(lambda: ros.probe.count_publishers(topics.STATUS.topic(robot)) > 0, "the view")
    ticks = iter(range(10_000))

    def is_shown() -> bool:
        tick = next(ticks)
        messages = dict(senses(make_agent_inputs(tick)))
        del messages[topics.FIX]
        messages[topics.RADIO_RX] = convert.encode_batch(pack_batch(tick, ALL_PARTS & ~Parts.FIX, ()))
        for channel, data in messages.items():
            speakers[channel].publish(data)
        return bool(batches and states)

    ros.wait(is_shown, "status")
    frames = map(decode_frame, unpack_batch(convert.decode_batch(batches[0])).frames)
    (hello,) = [frame for frame in frames if isinstance(frame, Hello)]
    return hello, {entry.key: entry.value for entry in states[0].status[0].values}


@pytest.mark.usefixtures("domain_id")
def test_a_robot_that_was_told_its_start_stands_there_from_the_first_tick() -> None:
    told = ("robot:=1", "start_x_m:=4.5", "start_y_m:=-2.0", "start_sigma_m:=1.5")
    with harness("--ros-args", *(part for setting in told for part in ("-p", setting))) as ros:
        ros.add(_from_parameters(ros.context))
        hello, shown = first_answer(ros, ROBOT)

    assert hello.presence.position.tolist() == [4.5, -2.0]
    assert hello.presence.sigma == pytest.approx(1.5, abs=0.02)
    assert 1.4 < float(shown["position_sigma_m"]) < 1.9


@pytest.mark.usefixtures("domain_id")
@pytest.mark.parametrize("told", [(), ("start_x_m:=4.5", "start_y_m:=-2.0")], ids=["nothing", "no sigma"])
def test_a_robot_that_was_not_told_how_well_its_start_is_known_does_not_know_it(told: tuple[str, ...]) -> None:
    with harness("--ros-args", *(part for setting in ("robot:=1", *told) for part in ("-p", setting))) as ros:
        ros.add(_from_parameters(ros.context))
        hello, shown = first_answer(ros, ROBOT)

    assert hello.presence.sigma == pytest.approx(SIGMA_UNKNOWN)
    assert shown["mode"] == "waiting"
