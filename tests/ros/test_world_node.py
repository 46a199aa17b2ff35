"""What the world publishes for each robot, and what it leaves unsaid."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import pytest
from rclpy.publisher import Publisher
from ros_harness import RosHarness, harness
from swarms import PERIOD, SMALL

from swarm_msgs_py import topics
from swarm_msgs_py.frames import unpack_batch
from swarm_msgs_py.ros import convert
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import NodeId
from swarm_sim.config import Backend, PhysicsConfig, RangingConfig, SimConfig
from swarm_sim.ros.world_node import WorldNode
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.simulation import Simulation

ROBOT = NodeId(0)


class Watched:
    """A world of two robots far apart, without agents, and what is heard on the first robot's topics."""

    def __init__(self, ros: RosHarness, world: WorldNode) -> None:
        self.ros, self.world = ros, world
        self.batches = ros.listen(topics.RADIO_RX, ROBOT, raw=True)

    def run(self, ticks: int) -> list[Parts]:
        """Let the world run, and return which parts it announced in each tick."""
        before = len(self.batches)
        for _ in range(ticks):
            self.world.begin()
            self.world.finish()
        self.ros.wait(lambda: len(self.batches) >= before + ticks, "the radio batches")
        return [Parts(unpack_batch(convert.decode_batch(data)).flags) for data in self.batches[before:]]

    def connect(self, *channels: topics.Channel) -> None:
        """Wait until the world's publishers know their listeners."""
        publishers = {p.topic_name: p for p in self.world.publishers}
        for channel in (topics.RADIO_RX, *channels):
            publisher = publishers[channel.topic(ROBOT)]
            wanted = self.ros.probe.count_subscribers(channel.topic(ROBOT))
            self.ros.wait(partial(_is_matched, publisher, wanted), channel.template)


def _is_matched(publisher: Publisher, listeners: int) -> bool:
    return publisher.get_subscription_count() >= listeners > 0


@pytest.fixture
def watched(domain_id: int) -> Iterator[Watched]:
    assert domain_id
    robots = tuple(RobotSpec(NodeId(k), SMALL, (8.0 * k, 0.0), 0.0, True) for k in range(2))
    config = SimConfig(physics=PhysicsConfig(backend=Backend.MASSDAMPER), ranging=RangingConfig(period_s=3.0))
    simulation = Simulation(config, Scene(robots, (), (-20.0, -20.0, 20.0, 20.0), (0.0, 0.0)), seed=1)
    with harness() as ros:
        yield Watched(ros, ros.add(WorldNode(simulation, PERIOD, context=ros.context)))
    simulation.close()


def test_ranges_are_published_and_announced_only_in_the_ticks_in_which_robots_range(watched: Watched) -> None:
    scans = watched.ros.listen(topics.RANGES, ROBOT, raw=True)
    watched.connect(topics.RANGES)

    parts = watched.run(13)
    watched.ros.wait(lambda: len(scans) >= 3, "range scans")

    assert [tick for tick, announced in enumerate(parts) if Parts.RANGES in announced] == [0, 6, 12]
    assert [convert.decode_ranges(data)[0] for data in scans] == [0, 6, 12]


def test_proximity_of_a_robot_with_nothing_near_is_published_only_when_somebody_else_listens(watched: Watched) -> None:
    watched.ros.listen(topics.PROXIMITY, ROBOT)  # stands for the robot itself
    watched.connect(topics.PROXIMITY)
    assert watched.run(2) == [Parts.IMU | Parts.FIX | Parts.RANGES, Parts.IMU | Parts.FIX]

    seen = watched.ros.listen(topics.PROXIMITY, ROBOT)
    watched.ros.wait(lambda: Parts.PROXIMITY in watched.run(1)[0], "proximity for a second listener")
    watched.ros.wait(lambda: len(seen) > 0, "a proximity message")

    assert len(seen[0].poses) == 0
