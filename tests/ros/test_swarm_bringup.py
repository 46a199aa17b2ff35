"""Launch files start nodes that exist, with parameters that they have; viewers' settings show topics that there are.

ROS's `launch` does not come as a wheel, so a few lines stand in for what the files use of it.
"""

from __future__ import annotations

import json
import re
import runpy
import sys
import types
from collections.abc import Iterator
from typing import Any, get_args, get_origin

import pytest
import yaml
from source_tree import SRC

from mission_computer.config import MissionConfig
from mission_computer.ros import mission_node
from swarm_agent.config import AgentConfig
from swarm_agent.ros import agent_node
from swarm_msgs_py import topics
from swarm_msgs_py.config import Config, dotted_keys
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.types import NodeId
from swarm_sim.config import SimConfig
from swarm_sim.ros import lockstep, world_node

BRINGUP = SRC / "swarm_bringup"
LAUNCH_FILES = sorted(path.name for path in (BRINGUP / "launch").glob("*.launch.py"))
ROBOTS = (NodeId(0), NodeId(1))
SERVICES = {topics.PAUSE_SERVICE, topics.RESUME_SERVICE, *(topics.power_service(robot) for robot in ROBOTS)}


class Recorded:
    """Stands for an action, substitution or description: keeps what it was made with."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named


class DeclareLaunchArgument(Recorded):
    """An argument of a launch file."""


class LaunchConfiguration(Recorded):
    """The value of an argument."""

    def perform(self, context: dict[str, str]) -> str:
        return context[self.arguments[0]]


class ParameterValue(Recorded):
    """A value with its type."""


class Node(Recorded):
    """A node to start."""


class OpaqueFunction(Recorded):
    """A function that makes actions."""


class Shutdown(Recorded):
    """The end of everything that was launched."""


class IncludeLaunchDescription(Recorded):
    """Another launch file."""


class PythonLaunchDescriptionSource(Recorded):
    """The path of another launch file."""


class LaunchDescription(Recorded):
    """All actions of a launch file."""


STAND_INS: dict[str, tuple[type, ...]] = {
    "launch": (LaunchDescription, type("LaunchContext", (dict,), {})),
    "launch.actions": (DeclareLaunchArgument, OpaqueFunction, IncludeLaunchDescription, Shutdown),
    "launch.substitutions": (LaunchConfiguration,),
    "launch.launch_description_sources": (PythonLaunchDescriptionSource,),
    "launch_ros": (),
    "launch_ros.actions": (Node,),
    "launch_ros.parameter_descriptions": (ParameterValue,),
}


@pytest.fixture(autouse=True)
def launch_library(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, members in STAND_INS.items():
        module = types.ModuleType(name)
        for member in members:
            setattr(module, member.__name__, member)
        monkeypatch.setitem(sys.modules, name, module)


def actions_of(path: str, given: dict[str, str]) -> Iterator[tuple[Node, dict[str, str]]]:
    """Yield all nodes that a launch file starts with these arguments, with the values of all arguments."""
    description = runpy.run_path(path)["generate_launch_description"]()
    context = dict(given)
    for action in description.arguments[0]:
        if isinstance(action, DeclareLaunchArgument):
            context.setdefault(action.arguments[0], action.named["default_value"])
        elif isinstance(action, IncludeLaunchDescription):
            yield from actions_of(action.arguments[0].arguments[0], context)
        else:
            made = action.named["function"](context) if isinstance(action, OpaqueFunction) else [action]
            yield from ((node, context) for node in made)


def nodes_of(path: str, given: dict[str, str]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Yield package, executable and parameters of those nodes."""
    for node, context in actions_of(path, given):
        (parameters,) = node.named["parameters"]
        yield node.named["package"], node.named["executable"], _valued(parameters, context)


def _valued(parameters: dict[str, Any], context: dict[str, str]) -> dict[str, Any]:
    return {
        name: value.named["value_type"](value.arguments[0].perform(context))
        if isinstance(value, ParameterValue)
        else value
        for name, value in parameters.items()
    }


def settings_of(package: str) -> tuple[type[Config], ...]:
    """Return the configurations that the node of a package declares as parameters."""
    return {
        "swarm_agent": (agent_node.AgentIdentity, AgentConfig),
        "mission_computer": (mission_node.MissionIdentity, MissionConfig, NetworkConfig),
        "swarm_sim": (world_node.WorldIdentity, SimConfig, lockstep.PaceConfig),
    }[package]


def fits(value: object, hint: Any) -> bool:
    """Return whether a parameter is of the type of its setting; sequences are lists in ROS."""
    if get_origin(hint) is tuple:
        return isinstance(value, list) and all(type(part) is get_args(hint)[0] for part in value)
    return type(value) is hint


@pytest.mark.parametrize("name", LAUNCH_FILES)
def test_launch_files_start_nodes_that_exist_with_parameters_that_they_have(name: str) -> None:
    found = list(nodes_of(str(BRINGUP / "launch" / name), {"counts": "2,1"}))

    assert found
    for package, executable, parameters in found:
        entry = f'"{executable} = {package}.ros.{executable}:main"'
        assert entry in (SRC / package / "setup.py").read_text("utf-8")
        known = {key: hint for kind in settings_of(package) for key, (hint, _) in dotted_keys(kind).items()}
        for key, value in parameters.items():
            assert key in known, f"{package} has no parameter {key}"
            assert fits(value, known[key]), f"{key} is {known[key]}, not {value!r}"


@pytest.mark.parametrize(
    ("value", "hint", "does"),
    [
        ([2, 1], tuple[int, ...], True),
        ([2.0], tuple[int, ...], False),
        (["2"], tuple[int, ...], False),
        (2, tuple[int, ...], False),
        ([2], int, False),
        (0.5, float, True),
        (1, float, False),
        ("1", int, False),
    ],
)
def test_a_list_is_no_number_and_numbers_are_no_text(value: object, hint: Any, does: bool) -> None:
    assert fits(value, hint) is does


def test_everything_ends_with_the_world_or_the_mission_computer_and_goes_on_without_a_robot() -> None:
    found = [node for node, _ in actions_of(str(BRINGUP / "launch" / "swarm.launch.py"), {"counts": "2"})]

    ends = {node.named["package"]: node.named.get("on_exit") for node in found}
    assert isinstance(ends["swarm_sim"], Shutdown)
    assert isinstance(ends["mission_computer"], Shutdown)
    assert ends["swarm_agent"] is None


def test_the_whole_swarm_is_a_world_a_mission_computer_and_every_robot() -> None:
    found = list(nodes_of(str(BRINGUP / "launch" / "swarm.launch.py"), {"counts": "2,1", "shape": "iso_1_circle"}))

    assert [package for package, _, _ in found] == ["swarm_sim", "mission_computer", *["swarm_agent"] * 3]
    assert [parameters.get("counts") for _, _, parameters in found[:2]] == [[2, 1]] * 2
    assert found[1][2]["shape"] == "iso_1_circle"
    assert [(its["robot"], its["type"]) for _, _, its in found[2:]] == [(0, 1), (1, 1), (2, 2)]


def test_arguments_of_a_robot_reach_its_node() -> None:
    ((_, _, parameters),) = nodes_of(
        str(BRINGUP / "launch" / "robot.launch.py"), {"robot": "7", "type": "3", "start_sigma_m": "2.0"}
    )

    assert (parameters["robot"], parameters["type"], parameters["start_sigma_m"]) == (7, 3, 2.0)


def test_rviz_shows_topics_that_there_are_as_they_are_published() -> None:
    settings = yaml.safe_load((BRINGUP / "config" / "swarm.rviz").read_text("utf-8"))["Visualization Manager"]
    shown = [display for display in settings["Displays"] if "Topic" in display]
    known = topics.all_topics(ROBOTS)

    assert settings["Global Options"]["Fixed Frame"] == "map"
    assert len(shown) >= 5
    for display in shown:
        kind = display["Class"].rpartition("/")[2]
        assert known[display["Topic"]["Value"]].rpartition("/")[2] == kind
    latched = {its["Topic"]["Value"] for its in shown if its["Topic"]["Durability Policy"] == "Transient Local"}
    assert latched == {channel.topic() for channel in (topics.MARKERS, topics.GOALS)}


def test_foxglove_shows_and_calls_what_there_is() -> None:
    layout = json.loads((BRINGUP / "config" / "foxglove.json").read_text("utf-8"))
    panels = layout["configById"]
    placed = set(re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"])))
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    paths += [panel["topicPath"] for panel in panels.values() if "topicPath" in panel]
    named = {*panels["3D!swarm"]["topics"], *(path.partition(".")[0] for path in paths)}

    assert placed == panels.keys()
    assert named <= topics.all_topics(ROBOTS).keys()
    assert {panel["serviceName"] for panel in panels.values() if "serviceName" in panel} <= SERVICES
