"""What a scenario says, in full: every setting with its value, unit and meaning; and which scenarios there are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import cast

import yaml

from bringup.family import AnyScenario
from bringup.scenario_file import SCENARIOS, load_any, scenario_names
from swarm_msgs_py.config import Config, Plain, dump_config, settings_of

INDENT = "  "
COMMENT_COLUMN = 44


def explain(scenario: AnyScenario) -> str:
    """Return a scenario as commented YAML, from which `load_any` makes an equal one.

    Behind each value stand its unit in brackets, what is allowed, and what it means.
    """
    return "\n".join([f"# {scenario.name}: {scenario.description}", *_lines(cast("Config", scenario), ""), ""])


def scenario_list() -> str:
    """Return one line per ready-made scenario, with its description."""
    names = scenario_names()
    width = max(map(len, names))
    lines = [f"{name:<{width}}  {load_any(name)[0].description}" for name in names]
    return "\n".join([*lines, f"Files: {SCENARIOS}", ""])


def _lines(config: Config, indent: str) -> Iterator[str]:
    """Yield the lines of one section."""
    settings, plain = settings_of(type(config)), dump_config(config)
    for f in fields(config):
        value, about = getattr(config, f.name), settings[f.name]
        unit, limits = f"[{about.unit}] " if about.unit else "", about.limits()
        remark = f"# {unit}{about.help}{f' ({limits})' if limits else ''}"
        if isinstance(value, Config):
            yield f"{indent}{f.name}:  {remark}"
            yield from _lines(value, indent + INDENT)
        elif isinstance(value, tuple) and value and all(isinstance(item, Config) for item in value):
            yield f"{indent}{f.name}:  {remark}"
            for item in value:
                first, *others = _lines(item, "")
                yield f"{indent}{INDENT}- {first}"
                yield from (f"{indent}{INDENT}  {line}" for line in others)
        else:
            yield f"{f'{indent}{f.name}: {_flow(plain[f.name])}':<{COMMENT_COLUMN}}  {remark}"


def _flow(value: Plain) -> str:
    """Return a value as YAML on one line."""
    text: str = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=float("inf"))
    return text.removesuffix("\n").removesuffix("\n...")
