"""Scenarios on disk and on the command line: YAML in, overrides on top, a strict `Scenario` out."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import yaml

from bringup.scenario import Scenario, rescaled_counts
from bringup.yaml_reader import YamlTextError, parse_yaml
from mission_computer.shape import library_names
from mission_computer.shape.library import suggestion
from swarm_msgs_py.config import at, dump_config, full_key, load_config, with_setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.robots import THESIS_TYPES

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios"
COMMAND_LINE = "command line"
ROBOT_COUNT = "robots.count"
"""Key of an override that rescales the mix of types to this many robots; no key of a file."""
FORCE_TASKS = tuple(task.value for task in Task if not task.has_goals)
"""Methods that are no partition of the shape."""


@dataclass(frozen=True, slots=True)
class Override:
    """One setting from the command line.

    Attributes
    ----------
    flag : str
        Option that said so, for errors.
    key : str
        Dotted key in the scenario.
    value : object
        Plain data.
    """

    flag: str
    key: str
    value: object


@dataclass(frozen=True, slots=True)
class Origin:
    """Who said what, so that an error names the place to mend.

    Attributes
    ----------
    file : str
        The scenario's file.
    overrides : tuple of Override
    """

    file: str
    overrides: tuple[Override, ...] = ()

    def of(self, key: str) -> str:
        """Return the place of `key` in an error: the option that set it (or a part of it), else the file."""
        for override in reversed(self.overrides):
            if f"{key}.".startswith(f"{override.key}."):
                return override.flag  # it set the whole of it
            if key.startswith(f"{override.key}["):
                return f"{override.flag}{key.removeprefix(override.key)}"  # the list that this is an entry of
            if override.key.startswith(f"{key}."):
                return f"{override.flag}: {key}"
        return at(self.file, key)


def scenario_names() -> tuple[str, ...]:
    """Return the names of all ready-made scenarios, in alphabetical order."""
    return tuple(sorted(path.stem for path in SCENARIOS.glob("*.yaml")))


def load_scenario(source: str, overrides: tuple[Override, ...] = ()) -> tuple[Scenario, Origin]:
    """Return a scenario with overrides applied, and who said what.

    Parameters
    ----------
    source : str
        Name of a ready-made scenario, or a YAML file.
    overrides : tuple of Override
        In the order in which they were given; later ones win.

    Raises
    ------
    ConfigError
        One line that names the file (or the option), the key and the remedy.
    """
    path = _path_of(source)
    data = _with_type_defaults(_parsed(path))
    scenario = load_config(Scenario, data, str(path))
    if not overrides:
        return scenario, Origin(str(path))
    try:
        return _overridden(data, scenario, overrides, COMMAND_LINE), Origin(str(path), overrides)
    except ConfigError:
        for override in overrides:  # blame the one that is wrong by itself
            _overridden(data, scenario, (override,), override.flag)
        raise


def dump_scenario(scenario: Scenario) -> str:
    """Return the YAML text from which `load_scenario` makes an equal scenario."""
    text: str = yaml.safe_dump(dump_config(scenario), sort_keys=False, allow_unicode=True, width=120)
    return text


def parse_assignment(text: str) -> Override:
    """Return the override of ``--set key=value``; the value is YAML, the key may be any unambiguous ending.

    Raises
    ------
    ConfigError
        If it is not an assignment, or the key does not exist or could be several.
    """
    key, equals, value = text.partition("=")
    where = f"--set {key.strip()}"
    if not equals or not key.strip():
        raise ConfigError(f"--set {text}: expected key=value, for example --set sim.radio.loss=0.1")
    try:
        parsed = parse_yaml(value)
    except YamlTextError:
        raise ConfigError(f"{where}: the value is not YAML; quote text, write lists as [1, 2]") from None
    return Override(where, full_key(Scenario, key.strip(), where), parsed)


def shape_override(source: str) -> Override:
    """Return the override of ``--shape``: a library name or a file; it replaces the shape with its placement."""
    is_file = source not in library_names() and (bool(Path(source).suffix) or "/" in source or Path(source).is_file())
    return Override(
        f"--shape {source}", "shape", {"file": str(Path(source).absolute())} if is_file else {"name": source}
    )


def method_overrides(name: str) -> tuple[Override, ...]:
    """Return the overrides of ``--method``: how shapes are partitioned, or that forces do it.

    With a partition method, who computes the goals is what suits it, unless a later override says otherwise.
    """
    flag = f"--method {name}"
    if name in FORCE_TASKS:
        return (Override(flag, "mission.task", name),)
    return Override(flag, "mission.partition.method", name), Override(flag, "mission.task", None)


def map_override(source: str) -> Override:
    """Return the override of ``--map``: a map of the package or a file."""
    is_file = bool(Path(source).suffix) or "/" in source
    return Override(f"--map {source}", "map", {"file": str(Path(source).absolute())} if is_file else {"name": source})


def _path_of(source: str) -> Path:
    if source in scenario_names():
        return _shortest(SCENARIOS / f"{source}.yaml")
    path = Path(source)
    if path.suffix or "/" in source:
        return path
    raise ConfigError(
        f"--scenario {source}: neither a ready-made scenario nor a file; {suggestion(source, scenario_names())}"
    )


def _shortest(path: Path) -> Path:
    """Return the path as people under the project's folder would write it."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def _parsed(path: Path) -> dict[str, Any]:
    try:
        data = parse_yaml(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ConfigError(
            f"{path}: no such file; give an existing one, or a ready-made scenario: {', '.join(scenario_names())}"
        ) from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror}); give a readable YAML file") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file; give a YAML file") from None
    except YamlTextError as error:
        raise ConfigError(f"{path}: {error}; correct it there") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: expected keys and values; start from one of the ready-made scenarios")
    stages = data.get("stages")
    parts = [data.get("shape"), data.get("map")]
    parts += [stage.get("shape") for stage in stages if isinstance(stage, dict)] if isinstance(stages, list) else []
    for part in parts:
        if isinstance(part, dict) and isinstance(part.get("file"), str):
            part["file"] = str(path.parent / part["file"])
    return data


def _with_type_defaults(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in what table 4.1 says of the robot types; anything malformed is left for the strict loader to refuse."""
    robots = data.get("robots")
    if not isinstance(robots, Mapping) or not isinstance(robots.get("types"), list):
        return data
    known = {kind.type: {f.name: getattr(kind, f.name) for f in fields(kind)} for kind in THESIS_TYPES}
    full = [
        {**known[group["type"]], **group}
        if isinstance(group, Mapping) and isinstance(group.get("type"), int) and group["type"] in known
        else group
        for group in robots["types"]
    ]
    return {**data, "robots": {**robots, "types": full}}


def _overridden(data: dict[str, Any], scenario: Scenario, overrides: tuple[Override, ...], where: str) -> Scenario:
    """Return the scenario that `data` and the overrides make together; `scenario` is the one of `data` alone."""
    data = copy.deepcopy(data)
    for override in overrides:
        if override.key == ROBOT_COUNT:
            assert isinstance(override.value, int)  # the option's own parser saw to it
            counts = rescaled_counts(tuple(group.count for group in scenario.robots.types), override.value)
            for group, count in zip(data["robots"]["types"], counts, strict=True):
                group["count"] = count
        else:
            with_setting(data, override.key, override.value, override.flag)
    return load_config(Scenario, _with_type_defaults(data), where)
