"""What the documents tell people to say to ROS: orders to a swarm that runs, nodes, launch files, topics, services."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
import rclpy
import yaml
from documented_commands import blocks, commands, starting_with, told
from orders import order_cli
from source_tree import ROOT, SRC

from bringup.ros_children import DIALECTS
from docs_site.reference import SENSORS, every_channel
from mission_computer.ros import mission_node
from swarm_msgs_py import topics
from swarm_msgs_py.ros.channels import message_type
from swarm_msgs_py.ros.spin import started
from swarm_msgs_py.topics import Channel, Party
from swarm_msgs_py.types import NodeId

SWARM = ("--scenario", "smoke-4", "--physics", "massdamper", "--real-time")
ENDLESS = ("--set", "duration_s=600", "--set", "success.hold_s=500")
LAUNCH = SRC / "swarm_bringup" / "launch"
ROBOTS = (NodeId(0), NodeId(3), NodeId(4))
SERVICES = {topics.PAUSE_SERVICE: "std_srvs/srv/Trigger", topics.RESUME_SERVICE: "std_srvs/srv/Trigger"} | {
    topics.power_service(robot): "std_srvs/srv/SetBool" for robot in ROBOTS
}


@pytest.fixture
def swarm(domain_id: int, tmp_path: Path) -> Iterator[Path]:
    """Start four robots that leave an operator time; return the file of what their launcher prints."""
    assert domain_id
    said = tmp_path / "said.txt"
    with said.open("w") as file:
        launcher = subprocess.Popen(
            [sys.executable, str(ROOT / "scripts/launch_swarm.py"), *SWARM, *ENDLESS, "--out", str(tmp_path / "run")],
            stdout=file,
            stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
        )
        try:
            yield said
        finally:
            launcher.terminate()
            launcher.wait(30)


def test_documented_orders_and_scripts_reach_a_swarm(swarm: Path, capfd: pytest.CaptureFixture[str]) -> None:
    orders = commands("scripts/order.py")
    scripts = [text for _, text in blocks("python") if "rclpy.init()" in text]

    assert {words[0] for words in orders} >= {"shape", "pause", "resume", "kill", "add"}
    for words in orders:
        code = order_cli.main(["--wait", "30", *words])
        assert code == order_cli.DONE, (told(words), capfd.readouterr(), swarm.read_text())
    out = capfd.readouterr().out
    for text in ("simulated time stands at tick", "r03 is off from tick", "r03 is on from tick"):
        assert text in out

    assert len(scripts) == 2
    for text in scripts:
        exec(compile(text, "README.md", "exec"), {})  # as a person does who copies it
        rclpy.shutdown()
    out = capfd.readouterr().out
    assert "/clock rosgraph_msgs/msg/Clock" in out
    assert "/world/power/r03 r03 is off from tick" in out


def test_an_order_without_a_swarm_ends_in_one_line(domain_id: int, capfd: pytest.CaptureFixture[str]) -> None:
    assert domain_id
    codes = [order_cli.main(["--wait", "0.3", *words]) for words in (["pause"], ["shape", "hw_2_square"])]

    assert codes == [order_cli.BAD_INPUT] * 2
    assert capfd.readouterr().err.splitlines() == [
        "error: nobody offers /world/pause; start a swarm that leaves you time, in the same ROS_DOMAIN_ID",
        "error: nobody listens on /mission/shape; start a swarm that leaves you time, in the same ROS_DOMAIN_ID",
    ]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["shape", "text:A"], "text:A: drawings and texts have no size; give --area"),
        (["shape", "nowhere.svg", "--area", "9"], "nowhere.svg: no such file"),
        (["kill", "robot3"], "expected a robot, as in r03 or 3, got 'robot3'"),
        (["halt"], "invalid choice: 'halt'"),
        ([], "ORDER"),
    ],
)
def test_orders_without_sense_are_refused_in_one_line(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert order_cli.main(words) == order_cli.BAD_INPUT
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line


@pytest.mark.parametrize("words", starting_with("ros2", "topic"), ids=told)
def test_documented_topics_and_messages_exist(words: tuple[str, ...]) -> None:
    verb, name = words[2], next(word for word in words if word.startswith("/"))
    table: dict[str, Channel] = topics.channels_by_topic(ROBOTS, tuple(every_channel_of_robots()), has_camera=True)
    channel = table[name]

    if verb != "pub":
        assert verb in {"echo", "hz"}
        return
    kind, text = words[words.index(name) + 1 :]
    assert (kind, channel.source) == (channel.message, Party.OPERATOR)
    assert filled(message_type(kind), yaml.safe_load(text)) != message_type(kind)()


@pytest.mark.parametrize("words", starting_with("ros2", "service"), ids=told)
def test_documented_services_and_requests_exist(words: tuple[str, ...]) -> None:
    verb, name, kind, *request = words[2:]
    package, _, type_name = kind.partition("/srv/")

    assert (verb, SERVICES[name]) == ("call", kind)
    filled(getattr(import_module(f"{package}.srv"), type_name).Request, yaml.safe_load(request[0]) if request else {})


@pytest.mark.usefixtures("domain_id")
@pytest.mark.parametrize("words", starting_with("ros2", "run", "mission_computer"), ids=told)
def test_documented_mission_computers_are_made(words: tuple[str, ...]) -> None:
    assert words[3] == "mission_node"
    with started(list(words[4:])) as executor:
        node = mission_node._from_parameters(executor.context)
        (counts,) = (word.partition(":=")[2] for word in words if word.startswith("counts:="))
        assert list(node.get_parameter("counts").value) == yaml.safe_load(counts)
        node.destroy_node()


@pytest.mark.parametrize("words", starting_with("ros2", "launch"), ids=told)
def test_documented_launch_files_have_their_arguments(words: tuple[str, ...]) -> None:
    package, name, *given = words[2:]
    arguments = arguments_of(LAUNCH / name)

    assert package == "swarm_bringup"
    assert {text.partition(":=")[0] for text in given if not text.startswith("--")} <= arguments
    assert {text for text in given if text.startswith("--")} <= {"--show-args"}


def test_the_reference_has_the_topics_that_nodes_of_every_family_use() -> None:
    for family, sensors in SENSORS.items():
        dialect = DIALECTS[family.value]
        assert set(dialect.sensors) == set(sensors)
        assert set(dialect.sensors) | set(dialect.shown) <= set(every_channel())


def every_channel_of_robots() -> set[Channel]:
    return {channel for sensors in SENSORS.values() for channel in sensors}


def arguments_of(path: Path) -> set[str]:
    """Return the names of the arguments that a launch file declares, or the files that it includes."""
    text = path.read_text("utf-8")
    names = set(re.findall(r'DeclareLaunchArgument\("(\w+)"', text))
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Dict):
            names |= {ast.literal_eval(key) for key in node.value.keys if key is not None}
    included = set(re.findall(r'"(\w+\.launch\.py)"', text))
    return names.union(*(arguments_of(path.parent / name) for name in included))


def filled(kind: Any, fields: dict[str, Any]) -> Any:
    """Return a message with these fields, as ``ros2 topic pub`` makes it of YAML; others keep their defaults."""
    message = kind()
    for name, value in fields.items():
        setattr(message, name, converted(kind.get_fields_and_field_types()[name], getattr(message, name), value))
    return message


def converted(declared: str, present: Any, value: Any) -> Any:
    if isinstance(value, dict):
        return filled(type(present), value)
    if isinstance(value, list):
        package, _, name = declared.removeprefix("sequence<").rstrip(">").partition("/")
        return [filled(message_type(f"{package}/msg/{name}"), each) for each in value]
    return type(present)(value)
