"""A shape that moves, with real processes: the same motion as without ROS, whatever the plan asks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
import pytest
from ros_harness import harness
from swarms import PERIOD, SMALL, SQUARE, SmallSwarm

from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine
from mission_computer.config import MissionConfig
from mission_computer.mission import Mission
from mission_computer.ros.mission_node import MissionNode
from mission_computer.stages import Stage
from swarm_msgs_py import topics
from swarm_msgs_py.frames import pack_batch
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.plan_motion import is_moving
from swarm_msgs_py.ros import convert
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import MISSION, NodeId

pytestmark = pytest.mark.usefixtures("domain_id")

TICKS = 26


@dataclass(frozen=True)
class MovingSwarm(SmallSwarm):
    """The small swarm whose square moves north by itself as soon as it is told."""

    @property
    def mission_config(self) -> MissionConfig:
        return replace(super().mission_config, lead_s=2.0)

    def mission(self) -> Mission:
        stage = Stage(SQUARE + np.array([0.0, 3.0]), over_s=8.0, at_s=1.0)
        roster = Roster.of([SMALL] * self.count)
        return Mission(self.mission_config, NetworkConfig(), roster, (), SQUARE, PERIOD, stages=(stage,))


@pytest.mark.usefixtures("nothing_left")
@pytest.mark.parametrize("task", [Task.GOALS, Task.PARTITION, Task.FORCES])
def test_robots_follow_a_moving_shape_to_the_byte_as_without_ros(task: Task) -> None:
    swarm = MovingSwarm(3, task=task)
    with RosEngine(swarm, agents_per_process=2) as engine:
        records = list(islice(engine.ticks(), TICKS))
    with InProcessEngine(swarm) as reference:
        expected = list(islice(reference.ticks(), TICKS))

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert record.mission == wanted.mission
        assert [its.goals_crc for its in record.reports.values()] == [its.goals_crc for its in wanted.reports.values()]
    plans = {record.tick: record.plan for record in records if record.plan is not None}
    assert sorted(plans) == [0, 2]
    assert plans[2].follows == (1 if task.has_goals else 0)
    assert [is_moving(plans[2], tick) for tick in (5, 6, 21, 22)] == [False, True, True, False]
    mission = records[-1].mission
    assert mission is not None
    assert (mission.stage, mission.stages_left, mission.is_broken_off) == (1, 0, False)
    assert {report.epoch for report in records[-1].reports.values()} == {2}
    assert records[-1].truth.positions[NodeId(0), 1] < records[0].truth.positions[NodeId(0), 1]


def test_viewers_see_where_shape_and_goals_are_in_every_tick_of_a_motion() -> None:
    with harness() as ros:
        ros.add(MissionNode(MovingSwarm(2).mission(), PERIOD, context=ros.context))
        goals, markers = ros.listen(topics.GOALS), ros.listen(topics.MARKERS)
        answers, radio = ros.listen(topics.RADIO_TX, MISSION), ros.speaker(topics.RADIO_RX, MISSION)
        ros.wait(lambda: ros.probe.count_publishers(topics.MARKERS.topic()) > 0, "a publisher of markers")
        for tick in range(TICKS):
            radio.publish(convert.encode_batch(pack_batch(tick, Parts.NONE, ())))
            ros.wait(lambda seen=tick: len(answers) > seen, "an answer")  # type: ignore[misc]
        ros.wait(lambda: len(markers) == len(goals) == 18, "two plans and sixteen ticks of motion")

    heights = np.array([[pose.position.y for pose in message.poses] for message in goals])
    assert (np.diff(heights[1:], axis=0) > 0.0).all()
    np.testing.assert_allclose(heights[-1] - heights[0], 3.0, atol=0.011)
    outlines = [message.markers[1].points for message in markers]
    assert [min(point.y for point in outline) for outline in (outlines[0], outlines[-1])] == [-3.0, 0.0]
