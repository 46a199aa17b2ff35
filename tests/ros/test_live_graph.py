"""Nobody cheats, seen from outside: the graph of the processes that the engine really starts."""

from __future__ import annotations

from itertools import islice

import pytest
from ros_harness import harness
from swarms import SmallSwarm

from bringup.compose import ScenarioActors
from bringup.resolution import resolve
from bringup.ros_engine import LEAN_FROM, RosEngine
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_msgs_py import topics
from swarm_msgs_py.ros.environment import PROFILE_VARIABLES
from swarm_msgs_py.types import MISSION, NodeId, robot_name

OF_ROS = {"/rosout", "/parameter_events"}
"""Topics on which every node of ROS may speak, and to which no robot listens."""
UNKNOWN = "_NODE_NAME_UNKNOWN_"
"""What ROS calls the node of an end that was discovered before its node."""


@pytest.mark.parametrize("count", [4, 20])
@pytest.mark.usefixtures("domain_id")
def test_no_robot_of_a_real_run_has_ears_or_a_mouth_outside_its_namespace(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    actors = SmallSwarm(count)
    with RosEngine(actors) as engine:
        ticks = engine.ticks()
        assert all(record.alerts == () for record in islice(ticks, 3))
        for name in PROFILE_VARIABLES:  # the engine's own file is gone by now; the harness makes another
            monkeypatch.delenv(name)
        with harness() as ros:
            probe, expected = ros.probe, topics.all_topics(actors.robots)

            def heard(robot: NodeId) -> set[str]:
                return {name for name, _ in probe.get_subscriber_names_and_types_by_node("agent", space(robot))}

            def spoken(robot: NodeId) -> set[str]:
                return {name for name, _ in probe.get_publisher_names_and_types_by_node("agent", space(robot))}

            def is_complete() -> bool:
                agents = {entry for entry in probe.get_node_names_and_namespaces() if entry[0] == "agent"}
                if agents != {("agent", space(robot)) for robot in actors.robots}:
                    return False
                types = dict(probe.get_topic_names_and_types())
                robots = all(heard(r) >= names(topics.ROBOT_SENSORS, r) for r in actors.robots)
                robots = robots and all(spoken(r) >= names(topics.ROBOT_ANSWERS, r) for r in actors.robots)
                return robots and types.keys() >= expected.keys()

            ros.wait(is_complete, "the whole swarm on the graph")
            for robot in actors.robots:
                assert heard(robot) == names(topics.ROBOT_SENSORS, robot)
                assert spoken(robot) - OF_ROS == names((*topics.ROBOT_ANSWERS, *topics.ROBOT_VIEWS), robot)
                assert not probe.get_client_names_and_types_by_node("agent", space(robot))
                offered = probe.get_service_names_and_types_by_node("agent", space(robot))
                assert bool(offered) == (count < LEAN_FROM)
            live = {name: kinds for name, kinds in probe.get_topic_names_and_types() if name not in OF_ROS}
            assert live == {name: [kind] for name, kind in expected.items()}
        assert len(list(islice(ticks, 20))) == 20


def space(robot: NodeId) -> str:
    return f"/{robot_name(robot)}"


def names(channels: tuple[topics.Channel, ...], robot: NodeId) -> set[str]:
    return {channel.topic(robot) for channel in channels}


@pytest.mark.usefixtures("domain_id")
def test_no_robot_under_a_camera_sees_its_images_or_the_truth(monkeypatch: pytest.MonkeyPatch) -> None:
    fast = parse_assignment("sim.physics.backend=massdamper")
    actors = ScenarioActors(resolve(*load_scenario("arena", (fast,))))
    with RosEngine(actors) as engine:
        ticks = engine.ticks()
        assert all(record.alerts == () for record in islice(ticks, 3))
        for name in PROFILE_VARIABLES:
            monkeypatch.delenv(name)
        with harness() as ros:
            probe, expected = ros.probe, topics.all_topics(actors.robots, has_camera=True)
            eyes = (topics.CAMERA_IMAGE.topic(), topics.CAMERA_INFO.topic())
            inputs = {*eyes, topics.SHAPE.topic(), topics.RADIO_RX.topic(MISSION)}

            def heard(node: str, namespace: str) -> set[str]:
                return {name for name, _ in probe.get_subscriber_names_and_types_by_node(node, namespace)} - OF_ROS

            def is_complete() -> bool:
                nodes = set(probe.get_node_names_and_namespaces())
                wanted = {("agent", space(robot)) for robot in actors.robots} | {("mission_computer", "/mission")}
                if not wanted <= nodes or not dict(probe.get_topic_names_and_types()).keys() >= expected.keys():
                    return False
                ends = [
                    *(end for name in eyes for end in probe.get_publishers_info_by_topic(name)),
                    *(end for name in eyes for end in probe.get_subscriptions_info_by_topic(name)),
                ]
                if any(end.node_name == UNKNOWN for end in ends):
                    return False
                ears = all(heard("agent", space(r)) >= names(topics.ROBOT_SENSORS, r) for r in actors.robots)
                return ears and heard("mission_computer", "/mission") >= inputs

            ros.wait(is_complete, "the whole arena on the graph")
            for robot in actors.robots:
                assert heard("agent", space(robot)) == names(topics.ROBOT_SENSORS, robot)
            assert heard("mission_computer", "/mission") == inputs
            for name in eyes:
                assert [end.node_name for end in probe.get_publishers_info_by_topic(name)] == ["world"]
                assert [end.node_name for end in probe.get_subscriptions_info_by_topic(name)] == ["mission_computer"]
            assert not probe.get_subscriptions_info_by_topic(topics.TRUTH.topic())
