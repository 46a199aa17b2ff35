"""Scenarios on disk and on the command line: YAML in, overrides on top, a strict scenario of its family out."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any, cast

import yaml

from bringup.family import AnyScenario, Family, Kind
from bringup.formation_kind import FORCE_TASKS, map_override, method_overrides, shape_override
from bringup.kinds import KINDS
from bringup.origin import COMMAND_LINE, Origin, Override
from bringup.scenario import Scenario
from bringup.yaml_reader import YamlTextError, parse_yaml
from mission_computer.shape.library import suggestion
from swarm_msgs_py.config import Config, dump_config, full_key, load_config, with_setting
from swarm_msgs_py.errors import ConfigError

__all__ = [
    "COMMAND_LINE",
    "FORCE_TASKS",
    "ROBOT_COUNT",
    "SCENARIOS",
    "Origin",
    "Override",
    "dump_scenario",
    "family_of",
    "load_any",
    "load_scenario",
    "map_override",
    "method_overrides",
    "parse_assignment",
    "scenario_names",
    "shape_override",
]

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios"
"""Those of the formation family; other families have a folder each in it."""

ROBOT_COUNT = "robots.count"
"""Key of an override that sets the number of robots, whatever a family makes it from."""


def scenario_names(family: Family | None = None) -> tuple[str, ...]:
    """Return the names of all ready-made scenarios, or of those of one family, in alphabetical order."""
    families = list(Family) if family is None else [family]
    return tuple(sorted(path.stem for member in families for path in _folder_of(member).glob("*.yaml")))


def family_of(source: str) -> Family:
    """Return the family of a scenario by name or file; of one that says nothing legible, the formation family.

    Raises
    ------
    ConfigError
        If there is no such scenario, or it is not legible.
    """
    return _family_of(_parsed(_path_of(source)))


def load_any(source: str, overrides: tuple[Override, ...] = ()) -> tuple[AnyScenario, Origin]:
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
    parsed = _parsed(path)
    kind = KINDS[_family_of(parsed)]
    kind.located(parsed, str(path.parent))
    data = kind.completed(parsed)
    scenario = load_config(kind.scenario, data, str(path))
    if not overrides:
        return cast("AnyScenario", scenario), Origin(str(path))
    try:
        return _overridden(kind, data, overrides, COMMAND_LINE), Origin(str(path), overrides)
    except ConfigError:
        for override in overrides:  # blame the one that is wrong by itself
            _overridden(kind, data, (override,), override.flag)
        raise


def load_scenario(source: str, overrides: tuple[Override, ...] = ()) -> tuple[Scenario, Origin]:
    """Return what `load_any` does of a scenario of the formation family, and refuse all others.

    Raises
    ------
    ConfigError
        One line that names the file (or the option), the key and the remedy.
    """
    scenario, origin = load_any(source, overrides)
    if not isinstance(scenario, Scenario):
        names = ", ".join(scenario_names(Family.FORMATION))
        raise ConfigError(f"{origin.of('family')}: only formation scenarios will do here, such as {names}")
    return scenario, origin


def dump_scenario(scenario: AnyScenario) -> str:
    """Return the YAML text from which `load_any` makes an equal scenario."""
    data = dump_config(cast("Config", scenario))
    text: str = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=120)
    return text


def parse_assignment(text: str, scenario: type[Config] = Scenario) -> Override:
    """Return the override of ``--set key=value``; the value is YAML, the key may be any unambiguous ending.

    Raises
    ------
    ConfigError
        If it is not an assignment, or the key does not exist in the class of `scenario` or could be several.
    """
    key, equals, value = text.partition("=")
    where = f"--set {key.strip()}"
    if not equals or not key.strip():
        raise ConfigError(f"--set {text}: expected key=value, for example --set sim.radio.loss=0.1")
    try:
        parsed = parse_yaml(value)
    except YamlTextError:
        raise ConfigError(f"{where}: the value is not YAML; quote text, write lists as [1, 2]") from None
    return Override(where, full_key(scenario, key.strip(), where), parsed)


def _folder_of(family: Family) -> Path:
    return SCENARIOS if family is Family.FORMATION else SCENARIOS / family.value


def _path_of(source: str) -> Path:
    for family in Family:
        path = _folder_of(family) / f"{source}.yaml"
        if source in scenario_names(family):
            return _shortest(path)
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
    return data


def _family_of(data: dict[str, Any]) -> Family:
    """Return the family that plain data name; what is no family is left for the strict loader to refuse."""
    named = data.get("family", Family.FORMATION.value)
    return next((family for family in Family if family.value == named), Family.FORMATION)


def _overridden(kind: Kind, data: dict[str, Any], overrides: tuple[Override, ...], where: str) -> AnyScenario:
    """Return the scenario that `data` and the overrides make together."""
    data = copy.deepcopy(data)
    for override in overrides:
        if override.key == ROBOT_COUNT:
            assert isinstance(override.value, int)  # the option's own parser saw to it
            kind.with_count(data, override.value)
        else:
            with_setting(data, override.key, override.value, override.flag)
    return cast("AnyScenario", load_config(kind.scenario, kind.completed(data), where))
