"""Settings are parameters with meaning and limits, and a wrong one is refused with a line that names it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from ros_harness import RosHarness, harness

from mission_computer.ros import mission_node
from swarm_agent.ros import agent_node
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.ros.parameters import declare_config, refuse_unknown_overrides
from swarm_sim.ros import world_node


class Color(Enum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True, slots=True, kw_only=True)
class Inner(Config):
    gain: float = setting(0.5, "how strongly", unit="1/s", above=0.0, maximum=2.0)
    points: tuple[float, ...] = setting((1.0, 2.0), "where", unit="m", minimum=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Spot(Config):
    color: Color = setting(Color.RED, "which")
    center_m: tuple[float, float] = setting((0.0, 0.0), "where", unit="m")


@dataclass(frozen=True, slots=True, kw_only=True)
class Floor(Config):
    spots: tuple[Spot, ...] = setting((), "what lies about")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outer(Config):
    count: int = setting(3, "how many", minimum=1, maximum=9)
    color: Color = setting(Color.RED, "which")
    is_on: bool = setting(True, "whether")
    inner: Inner = section(Inner)


@pytest.fixture
def ros(domain_id: int) -> Iterator[RosHarness]:
    assert domain_id
    with harness() as ready:
        yield ready


def node_with(ros: RosHarness, **overrides: Any) -> Node:
    given = [Parameter(name.replace("__", "."), value=value) for name, value in overrides.items()]
    return ros.add(Node("tuned", context=ros.context, parameter_overrides=given))  # type: ignore[no-any-return]


def test_every_setting_becomes_a_read_only_parameter_with_its_meaning_unit_and_range(ros: RosHarness) -> None:
    node = node_with(ros)

    assert declare_config(node, Outer()) == Outer()

    gain = node.describe_parameter("inner.gain")
    assert (gain.description, gain.read_only) == ("how strongly [1/s]", True)
    assert (gain.floating_point_range[0].from_value, gain.floating_point_range[0].to_value) == (0.0, 2.0)
    assert node.describe_parameter("count").integer_range[0].to_value == 9
    assert node.describe_parameter("color").additional_constraints == "one of red, blue"
    assert list(node.get_parameter("inner.points").value) == [1.0, 2.0]


def test_overrides_are_what_the_node_runs_with(ros: RosHarness) -> None:
    node = node_with(ros, count=5, color="blue", is_on=False, inner__gain=1.5, inner__points=[4.0])

    config = declare_config(node, Outer())

    assert config == Outer(count=5, color=Color.BLUE, is_on=False, inner=Inner(gain=1.5, points=(4.0,)))


def test_records_are_texts_in_json_as_defaults_and_as_overrides(ros: RosHarness) -> None:
    blue = Floor(spots=(Spot(color=Color.BLUE, center_m=(0.5, -0.25)), Spot()))

    assert declare_config(node_with(ros), blue) == blue
    assert declare_config(node_with(ros), Floor()) == Floor()
    override = ['{"color": "blue", "center_m": [0.5, -0.25]}', "{}"]
    assert declare_config(node_with(ros, spots=override), Floor()) == blue
    assert declare_config(node_with(ros, spots=override[:1]), blue) == Floor(spots=blue.spots[:1])


@pytest.mark.parametrize(
    ("spots", "line"),
    [
        (["red"], "parameters of /tuned: spots: expected a list of texts, each a record in JSON"),
        ([1.0], "parameters of /tuned: spots: expected a list of texts, each a record in JSON"),
        (['{"hue": 3}'], "hue"),
    ],
)
def test_a_record_that_cannot_be_read_is_refused_by_name(ros: RosHarness, spots: list[Any], line: str) -> None:
    with pytest.raises(ConfigError, match=line):
        declare_config(node_with(ros, spots=spots), Floor())


@pytest.mark.parametrize(
    ("override", "line"),
    [
        ({"count": 10}, "parameters of /tuned: count: expected a whole number >= 1 and <= 9"),
        ({"count": "many"}, "parameters of /tuned: count: expected a whole number"),
        ({"color": "green"}, "parameters of /tuned: color: got 'green'"),
        ({"inner__gain": 0.0}, "parameters of /tuned: inner.gain: must be > 0"),
        ({"inner__gain": 1}, "inner.gain: expected a number with a decimal point"),
        ({"inner__points": [-1.0]}, r"inner.points\[0\]: must be >= 0 m"),
    ],
)
def test_a_wrong_override_is_refused_by_name(ros: RosHarness, override: dict[str, Any], line: str) -> None:
    node = node_with(ros, **override)

    with pytest.raises(ConfigError, match=line):
        declare_config(node, Outer())


def test_a_parameter_that_nobody_declares_is_refused(ros: RosHarness) -> None:
    node = node_with(ros, colour="red")
    declare_config(node, Outer())

    with pytest.raises(ConfigError, match="unknown parameter 'colour'"):
        refuse_unknown_overrides(node)


@pytest.mark.usefixtures("domain_id")
@pytest.mark.parametrize("main", [agent_node.main, mission_node.main, world_node.main])
def test_a_node_started_by_itself_ends_with_code_2_on_bad_input(main: Any, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--ros-args", "-p", "no_such_setting:=1"])

    assert end.value.code == 2
    assert "unknown parameter 'no_such_setting'" in capfd.readouterr().err


def test_a_mission_computer_started_by_itself_can_be_told_the_covers_under_its_camera(ros: RosHarness) -> None:
    identity = declare_config(
        node_with(ros, colors="blue, red", counts=[1, 1], cover_radii_m=[0.16, 0.11]), mission_node.MissionIdentity()
    )

    assert [(int(cover.robot), cover.color, cover.radius) for cover in identity.covers] == [
        (0, MarkerColor.BLUE, 0.16),
        (1, MarkerColor.RED, 0.11),
    ]
    assert mission_node.MissionIdentity().covers == ()


@pytest.mark.parametrize(
    ("colors", "words"), [("red,blue", "each of the 5"), ("red,blue,red,pink,green", "'red' is"), ("a,b,c,d,e", "'a'")]
)
def test_covers_that_do_not_fit_the_robots_are_refused(colors: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        mission_node.MissionIdentity(colors=colors, counts=(1, 2, 2))
