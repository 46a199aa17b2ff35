"""The channel table names every topic once, in the namespace of whom it belongs to."""

from __future__ import annotations

import pytest

from swarm_msgs_py import topics
from swarm_msgs_py.types import MISSION, NodeId


def test_a_robot_has_its_topics_in_its_own_namespace() -> None:
    assert topics.IMU.topic(NodeId(7)) == "/r07/imu"
    assert topics.RADIO_RX.topic(NodeId(123)) == "/r123/radio/rx"
    assert topics.RADIO_TX.topic(MISSION) == "/mission/radio/tx"


def test_a_topic_that_exists_once_has_its_name() -> None:
    assert topics.CLOCK.topic() == "/clock"


@pytest.mark.parametrize(("channel", "node"), [(topics.IMU, None), (topics.CLOCK, NodeId(1))])
def test_a_name_that_makes_no_sense_is_refused(channel: topics.Channel, node: NodeId | None) -> None:
    with pytest.raises(ValueError, match=channel.template.replace("{", r"\{").replace("}", r"\}")):
        channel.topic(node)


def test_no_two_channels_share_a_topic() -> None:
    robots = tuple(NodeId(number) for number in range(12))
    channels = len(robots) * len(topics.ROBOT_CHANNELS) + len(topics.MISSION_CHANNELS) + len(topics.SINGLE_CHANNELS)

    assert len(topics.all_topics(robots)) == channels


def test_robots_listen_to_the_world_and_to_nobody_else() -> None:
    assert {channel.source for channel in topics.ROBOT_SENSORS} == {topics.Party.WORLD}
    assert {channel.sink for channel in topics.ROBOT_ANSWERS} == {topics.Party.WORLD}
