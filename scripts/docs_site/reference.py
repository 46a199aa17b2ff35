"""Reference pages: command lines, settings, topics, services and records, as the code has them."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import typing
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from importlib import import_module
from inspect import cleandoc, getmembers, isclass
from pathlib import Path
from types import ModuleType

from bringup.family import Family
from bringup.kinds import KINDS
from swarm_msgs_py import messages, topics
from swarm_msgs_py.config import Config, dotted_keys
from swarm_msgs_py.types import NodeId

SCRIPTS = Path(__file__).resolve().parents[1]
PATHS = ("reference/commands.md", "reference/settings.md", "reference/messages.md")
"""Pages of the site that are no files."""

SENSORS = {
    Family.FORMATION: topics.ROBOT_SENSORS,
    Family.COVERAGE: topics.POINT_SENSORS,
    Family.ASSEMBLY: topics.BOAT_SENSORS,
}
"""What the world sends to robots of each family."""

OTHER_RECORDS = tuple(
    f"swarm_msgs_py.{name}"
    for name in (
        *("step_io", "coverage_io", "coverage_orders"),
        *("assembly.boat_io", "assembly.orders", "assembly.plan", "assembly.progress_frames", "assembly.boat_frames"),
    )
)
"""Modules outside of ``messages`` whose records actors hand to each other."""

WIDTH = "100"  # columns of the help texts


def pages() -> dict[str, str]:
    """Return the Markdown of every reference page, by its path in the site."""
    return dict(zip(PATHS, (commands_page(), settings_page(), messages_page()), strict=True))


def commands_page() -> str:
    """Return the help of every script."""
    parts = ["# Commands\n\nWhat `--help` says.\n"]
    for script in sorted(SCRIPTS.glob("*.py")):
        shown = subprocess.run(
            [sys.executable, str(script), "--help"],
            env=os.environ | {"COLUMNS": WIDTH, "NO_COLOR": "1", "MPLBACKEND": "Agg"},
            capture_output=True,
            text=True,
            check=True,
            stdin=subprocess.DEVNULL,
        )
        parts.append(f"## {script.name}\n\n```text\n{shown.stdout.strip()}\n```\n")
    return "\n".join(parts)


def settings_page() -> str:
    """Return every setting of a scenario of every family, by its dotted key."""
    lines = [
        "# Settings",
        "",
        "Keys of scenario files, and of `--set key=value`; there a unique ending is enough. `--explain` prints the"
        " values of one scenario. Robots' settings are the ROS parameters of their nodes. A scenario is of one family:"
        " `family` in it, or the folder of a ready-made one, says which.",
    ]
    for family, kind in KINDS.items():
        lines += ["", f"## The {family.value} family"]
        lines += _settings_of(kind.scenario)
    return "\n".join([*lines, ""])


def _settings_of(scenario: type[Config]) -> Iterator[str]:
    """Yield the tables of one family's settings, one per section."""
    defaults = _defaults(scenario)
    sections: dict[str, list[str]] = {"the run": []}
    for key, (hint, about) in dotted_keys(scenario).items():
        section = sections.setdefault(key.partition(".")[0] if "." in key else "the run", [])
        limits = about.limits() or (f"{about.unit}" if about.unit else "")
        section.append(f"| `{key}` | {_type_name(hint)} | {defaults.get(key, '')} | {limits} | {_cell(about.help)} |")
    for name, lines in sections.items():
        yield from (
            "",
            f"### {name}",
            "",
            "| key | type | default | allowed | meaning |",
            "| --- | --- | --- | --- | --- |",
        )
        yield from lines


def messages_page() -> str:
    """Return the topics, services and records of the system."""
    lines = ["# Topics, services, messages", "", "## Topics", ""]
    lines += ["`rNN` is the name of a robot, `r00` to `r99` and on. Families that a topic is of are named in the last"]
    lines += ["column; nothing there: all have it.", ""]
    lines += ["| topic | type | from | to | delivery | only in |", "| --- | --- | --- | --- | --- | --- |"]
    lines += [_channel_line(channel) for channel in every_channel()]
    lines += ["", "`/mission/radio/rx` and `/mission/radio/tx` are those of the mission computer's antenna.", ""]
    lines += ["## Services", "", "| service | type | what it does |", "| --- | --- | --- |"]
    lines.append(f"| `{topics.PAUSE_SERVICE}` | std_srvs/srv/Trigger | hold simulated time |")
    lines.append(f"| `{topics.RESUME_SERVICE}` | std_srvs/srv/Trigger | let simulated time go on |")
    power = topics.power_service(NodeId(0)).replace("r00", "rNN")
    lines.append(f"| `{power}` | std_srvs/srv/SetBool | false: kill the robot; true: switch it on |")
    lines += ["", "## Records", ""]
    lines.append("What travels in radio frames, and what actors hand to each other; typed views of the bytes.")
    for name in record_modules():
        module = import_module(name)
        if records := list(_records(module)):
            lines += ["", f"### {_first_line(module.__doc__)}", "", f"`{name}`", ""]
            lines += [line for record in records for line in _record_lines(record)]
    return "\n".join([*lines, ""])


def every_channel() -> list[topics.Channel]:
    """Return all rows of the topic table, in its order."""
    return [member for member in vars(topics).values() if isinstance(member, topics.Channel)]


def families_of(channel: topics.Channel) -> tuple[Family, ...]:
    """Return the families whose robots have a topic; none: it does not depend on the family."""
    if not any(channel in sensors for sensors in SENSORS.values()):
        return ()
    found = tuple(family for family, sensors in SENSORS.items() if channel in sensors)
    return () if len(found) == len(SENSORS) else found


def record_modules() -> list[str]:
    """Return the modules that hold records, by name."""
    package = Path(str(messages.__file__)).parent
    of_all = [f"{messages.__name__}.{path.stem}" for path in sorted(package.glob("[!_]*.py"))]
    return [*of_all, *OTHER_RECORDS]


def _channel_line(channel: topics.Channel) -> str:
    name = channel.template.replace("{node}", "rNN")
    only = ", ".join(family.value for family in families_of(channel))
    if channel in topics.CAMERA_CHANNELS:
        only = "worlds with an overhead camera"
    ends = f"{channel.source.value} | {channel.sink.value}"
    return f"| `{name}` | {channel.message} | {ends} | {channel.delivery.value} | {only} |"


def _records(module: ModuleType) -> Iterator[type]:
    """Yield the dataclasses and enumerations that a module defines, as they stand in it."""
    own = [member for _, member in getmembers(module, isclass) if member.__module__ == module.__name__]
    source = Path(str(module.__file__)).read_text(encoding="utf-8")
    for member in sorted(own, key=lambda kind: source.index(f"class {kind.__name__}")):
        if is_dataclass(member) or issubclass(member, Enum):
            yield member


def _record_lines(record: type) -> list[str]:
    if issubclass(record, Enum):
        values = ", ".join(f"`{member.name.lower()}` ({member.value})" for member in record)
        return [f"**{record.__name__}**: {_first_line(record.__doc__)} {values}", ""]
    meanings, hints = _attributes(record.__doc__ or ""), typing.get_type_hints(record)
    lines = [
        f"**{record.__name__}**: {_first_line(record.__doc__)}",
        "",
        "| field | type | meaning |",
        "| --- | --- | --- |",
    ]
    for f in fields(record):  # type: ignore[arg-type] # it is a dataclass
        kind, meaning = meanings.get(f.name, ("", ""))
        lines.append(f"| `{f.name}` | {_cell(kind or _type_name(hints[f.name]))} | {_cell(meaning)} |")
    return [*lines, ""]


def _attributes(doc: str) -> dict[str, tuple[str, str]]:
    """Return type and meaning of each attribute in a NumPy docstring."""
    _, _, section = cleandoc(doc).partition("Attributes\n----------\n")
    found: dict[str, tuple[str, str]] = {}
    names: list[str] = []
    for line in section.splitlines():
        if line and not line.startswith(" "):
            head, _, kind = line.partition(" : ")
            names = [name.strip() for name in head.split(",")]
            found |= dict.fromkeys(names, (kind, ""))
        elif line:
            found |= {name: (found[name][0], f"{found[name][1]} {line.strip()}".strip()) for name in names}
    return found


def _defaults(cls: type[Config], prefix: str = "") -> dict[str, str]:
    """Return the defaults of all settings that have one, by dotted key."""
    hints = typing.get_type_hints(cls)
    found: dict[str, str] = {}
    for f in fields(cls):
        hint = hints[f.name]
        if isinstance(hint, type) and issubclass(hint, Config):
            found |= _defaults(hint, f"{prefix}{f.name}.")
        elif f.default is not MISSING:
            value = f.default.value if isinstance(f.default, Enum) else f.default
            found[f"{prefix}{f.name}"] = "`[]`" if value == () else f"`{'null' if value is None else value}`"
    return found


def _type_name(hint: typing.Any) -> str:
    if isinstance(hint, type) and issubclass(hint, Enum):
        return ", ".join(f"`{member.value}`" for member in hint)
    text = hint.__name__ if isinstance(hint, type) and not typing.get_args(hint) else str(hint)
    return _cell(re.sub(r"\b(?:\w+\.)+(\w+)", r"\1", text))


def _first_line(doc: str | None) -> str:
    return (doc or "").strip().splitlines()[0]


def _cell(text: str) -> str:
    """Return text that does not end a cell of a table."""
    return text.replace("|", "\\|").replace("\n", " ")
