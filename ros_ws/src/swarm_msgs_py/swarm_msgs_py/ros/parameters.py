"""Configuration dataclasses as ROS parameters: dotted names, units, ranges, and no parameter that nobody reads."""

from __future__ import annotations

import json
import math
import sys
import typing
from collections.abc import Iterator
from contextlib import contextmanager
from enum import Enum
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from swarm_msgs_py.config import Config, Plain, Setting, dotted_keys, dump_config, load_config, with_setting
from swarm_msgs_py.errors import ConfigError

C = TypeVar("C", bound=Config)

BELONGS_TO_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
"""Parameters that ROS itself declares in every node."""


def declare_config(node: Node, default: C) -> C:
    """Declare the settings of a configuration as read-only parameters, and return what they were started with.

    Parameters
    ----------
    node : Node
    default : Config
        Values of the parameters that are not overridden.

    Raises
    ------
    ConfigError
        If an override has the wrong type or is outside the limits of its setting.
    """
    where, kind = f"parameters of {node.get_fully_qualified_name()}", type(default)
    defaults = dump_config(default)
    data: dict[str, Any] = {}
    for key, (hint, about) in dotted_keys(kind).items():
        value = _at(defaults, key)
        given = [json.dumps(record) for record in value] if _are_records(hint) else value
        try:
            chosen = node.declare_parameter(key, given, _descriptor(hint, about, given)).value
        except (InvalidParameterTypeException, InvalidParameterValueException) as error:
            raise ConfigError(f"{where}: {key}: expected {_expected(hint, about)}; {error}") from error
        if _are_records(hint):
            chosen = _records(chosen, f"{where}: {key}")
        with_setting(data, key, list(chosen) if isinstance(value, list) else chosen, where)
    return load_config(kind, data, where)


@contextmanager
def reader(name: str, context: Context) -> Iterator[Node]:
    """Hand out a short-lived node that reads a process's parameters, before the node that they describe can be made.

    Raises
    ------
    ConfigError
        At the end of the block, for a parameter that nothing in it has declared.
    """
    node = Node(f"{name}_parameters", context=context, enable_rosout=False)
    try:
        yield node
        refuse_unknown_overrides(node)
    finally:
        node.destroy_node()


def refuse_unknown_overrides(node: Node) -> None:
    """Check, after all declarations, that no parameter was given that the node does not have.

    Raises
    ------
    ConfigError
        Naming the first one; ROS itself would pass over a misspelt name in silence.
    """
    for name in sorted(node._parameter_overrides):  # rclpy has no public way to ask
        if not node.has_parameter(name) and not name.startswith(BELONGS_TO_ROS):
            raise ConfigError(
                f"parameters of {node.get_fully_qualified_name()}: unknown parameter '{name}'; "
                "`ros2 param list` shows those that exist"
            )


def _are_records(hint: Any) -> bool:
    """Return whether a setting is a list of things with settings of their own; ROS has no parameter for those."""
    inner = typing.get_args(hint)[:1] if typing.get_origin(hint) is tuple else ()
    return any(isinstance(one, type) and issubclass(one, Config) for one in inner)


def _records(texts: object, where: str) -> list[Any]:
    """Return what the texts of a parameter say, each one record in JSON."""
    if not isinstance(texts, (list, tuple)) or not all(isinstance(text, str) for text in texts):
        raise ConfigError(f"{where}: expected a list of texts, each a record in JSON, got {texts!r}")
    try:
        return [json.loads(text) for text in texts]
    except json.JSONDecodeError as error:
        raise ConfigError(f"{where}: expected a list of texts, each a record in JSON; {error}") from error


def _at(data: dict[str, Plain], key: str) -> Any:
    value: Any = data
    for part in key.split("."):
        value = value[part]
    return value


def _descriptor(hint: Any, about: Setting, value: object) -> ParameterDescriptor:
    """Return what ROS tools tell about a setting."""
    unit = f" [{about.unit}]" if about.unit else ""
    descriptor = ParameterDescriptor(
        description=f"{about.help}{unit}",
        additional_constraints=_expected(hint, about),
        read_only=True,
        dynamic_typing=value is None or _are_records(hint),  # an empty list has no type
    )
    is_limited = about.minimum is not None or about.maximum is not None or about.above is not None
    if is_limited and hint is float:
        low = about.minimum if about.minimum is not None else about.above
        low = low if low is not None else -sys.float_info.max
        high = about.maximum if about.maximum is not None else sys.float_info.max
        descriptor.floating_point_range = [FloatingPointRange(from_value=float(low), to_value=float(high))]
    elif is_limited and hint is int:
        low = about.minimum if about.minimum is not None else about.above
        lowest = -(2**63) if low is None else math.floor(low) + (about.minimum is None)
        highest = 2**63 - 1 if about.maximum is None else math.floor(about.maximum)
        descriptor.integer_range = [IntegerRange(from_value=int(lowest), to_value=int(highest), step=1)]
    return descriptor


def _expected(hint: Any, about: Setting) -> str:
    """Return type and limits of a setting in words."""
    if isinstance(hint, type) and issubclass(hint, Enum):
        return "one of " + ", ".join(str(member.value) for member in hint)
    if _are_records(hint):
        return "a list of texts, each a record in JSON"
    names = {float: "a number with a decimal point", int: "a whole number", bool: "true or false", str: "text"}
    kind = names.get(hint, "a list" if typing.get_origin(hint) is tuple else "a value")
    return f"{kind} {about.limits()}".rstrip()
