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

from bringup.scenario import Scenario
from swarm_msgs_py import topics
from swarm_msgs_py.config import Config, dotted_keys
from swarm_msgs_py.types import NodeId

SCRIPTS = Path(__file__).resolve().parents[1]
PATHS = ("reference/commands.md", "reference/settings.md", "reference/messages.md")
"""Pages of the site that are no files."""

RECORD_MODULES = ("radio", "bodies", "sensing", "control", "report")
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
    """Return every setting of a scenario, by its dotted key."""
    lines = [
        "# Settings",
        "",
        "Keys of scenario files, and of `--set key=value`; there a unique ending is enough. `--explain` prints the"
        " values of one scenario. Robots' settings are the ROS parameters of their nodes.",
    ]
    section = ""
    defaults = _defaults(Scenario)
    for key, (hint, about) in dotted_keys(Scenario).items():
        head = key.partition(".")[0] if "." in key else "the run"
        if head != section:
            section = head
            lines += [
                "",
                f"## {section}",
                "",
                "| key | type | default | allowed | meaning |",
                "| --- | --- | --- | --- | --- |",
            ]
        limits = about.limits() or (f"{about.unit}" if about.unit else "")
        lines.append(f"| `{key}` | {_type_name(hint)} | {defaults.get(key, '')} | {limits} | {_cell(about.help)} |")
    return "\n".join([*lines, ""])


def messages_page() -> str:
    """Return the topics, services and records of the system."""
    robot = NodeId(0)
    lines = ["# Topics, services, messages", "", "## Topics", "", "| topic | type | from | to | delivery |"]
    lines.append("| --- | --- | --- | --- | --- |")
    channels = dict.fromkeys((*topics.ROBOT_CHANNELS, *topics.MISSION_CHANNELS, *topics.SINGLE_CHANNELS))
    for channel in channels:
        name = channel.template.replace("{node}", "rNN")
        ends = f"{channel.source.value} | {channel.sink.value}"
        lines.append(f"| `{name}` | {channel.message} | {ends} | {channel.delivery.value} |")
    lines += [
        "",
        "`/mission/radio/rx` and `/mission/radio/tx` are those of the mission computer's antenna.",
        "",
        "## Services",
    ]
    lines += ["", "| service | type | what it does |", "| --- | --- | --- |"]
    lines.append(f"| `{topics.PAUSE_SERVICE}` | std_srvs/srv/Trigger | hold simulated time |")
    lines.append(f"| `{topics.RESUME_SERVICE}` | std_srvs/srv/Trigger | let simulated time go on |")
    power = topics.power_service(robot).replace("r00", "rNN")
    lines.append(f"| `{power}` | std_srvs/srv/SetBool | false: kill the robot; true: switch it on |")
    lines += [
        "",
        "## Records",
        "",
        "What travels in radio frames, and what actors hand to each other; typed views of the bytes.",
    ]
    for name in RECORD_MODULES:
        module = import_module(f"swarm_msgs_py.messages.{name}")
        lines += ["", f"### {_first_line(module.__doc__)}", ""]
        for record in _records(module):
            lines += _record_lines(record)
    return "\n".join([*lines, ""])


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
