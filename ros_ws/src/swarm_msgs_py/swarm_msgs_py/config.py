"""Settings: declared once as dataclass fields, checked strictly, readable from YAML, ROS parameters and ``--set``.

A setting carries its default, unit, range and meaning in its field, so that the loader's errors, the ROS parameter
descriptors and the JSON schema all tell the same story.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, TypeVar

from swarm_msgs_py.errors import ConfigError

_META = "swarm_setting"
C = TypeVar("C", bound="Config")
Plain = None | bool | int | float | str | list["Plain"] | dict[str, "Plain"]


@dataclass(frozen=True, slots=True)
class Setting:
    """Meaning and limits of one configuration field.

    Attributes
    ----------
    help : str
        What it does, with its source where it has one.
    unit : str
        Unit in words a newcomer reads, "" for pure numbers and text.
    minimum, maximum : float or None
        Inclusive limits.
    above : float or None
        Exclusive lower limit.
    """

    help: str
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    above: float | None = None

    def limits(self) -> str:
        """Return the allowed range in words, or ""."""
        parts = []
        if self.above is not None:
            parts.append(f"> {self.above:g}")
        if self.minimum is not None:
            parts.append(f">= {self.minimum:g}")
        if self.maximum is not None:
            parts.append(f"<= {self.maximum:g}")
        unit = f" {self.unit}" if self.unit else ""
        return " and ".join(parts) + unit if parts else ""

    def allows(self, number: float) -> bool:
        """Return whether `number` is finite and within the limits."""
        return (
            math.isfinite(number)
            and (self.above is None or number > self.above)
            and (self.minimum is None or number >= self.minimum)
            and (self.maximum is None or number <= self.maximum)
        )


def setting(  # noqa: PLR0913 - one keyword per fact about a setting
    default: Any = dataclasses.MISSING,
    help: str = "",  # noqa: A002 - the word that argparse users know
    *,
    unit: str = "",
    minimum: float | None = None,
    maximum: float | None = None,
    above: float | None = None,
) -> Any:
    """Declare a field of a `Config`: default, meaning, unit and limits.

    Raises
    ------
    ValueError
        If the default is mutable (as `dataclasses.field`).
    """
    return dataclasses.field(default=default, metadata={_META: Setting(help, unit, minimum, maximum, above)})


def section(factory: type[C], help: str = "") -> Any:  # noqa: A002
    """Declare a field that is a `Config` of its own, with all its defaults."""
    return dataclasses.field(default_factory=factory, metadata={_META: Setting(help)})


@dataclass(frozen=True, slots=True, kw_only=True)
class Config:
    """Base of every configuration dataclass: checks the limits of its settings when it is made."""

    def __post_init__(self) -> None:
        """Check every number against its setting's limits.

        Raises
        ------
        ConfigError
            Naming the class, the field, the value and the limits.
        """
        for name, about in settings_of(type(self)).items():
            for number in _numbers(getattr(self, name)):
                if not about.allows(number):
                    wanted = about.limits() or "a finite number"
                    raise ConfigError(f"{name} must be {wanted}, got {number:g}")


def settings_of(cls: type[Config]) -> dict[str, Setting]:
    """Return the declared settings of a configuration class, by field name."""
    return {f.name: f.metadata[_META] for f in dataclasses.fields(cls) if _META in f.metadata}


def _numbers(value: object) -> list[float]:
    if isinstance(value, bool | Enum):
        return []
    if isinstance(value, int | float):
        return [float(value)]
    if isinstance(value, tuple):
        return [number for item in value for number in _numbers(item)]
    return []


def load_config(cls: type[C], data: object, where: str = "") -> C:
    """Return a configuration from plain data, refusing everything that is not exactly as declared.

    Parameters
    ----------
    cls : type
        A `Config` dataclass.
    data : object
        Mapping of field names to values, as a YAML parser returns it.
    where : str
        File (and key) that the data came from; begins every error.

    Raises
    ------
    ConfigError
        For an unknown or missing key, a wrong type, or a value outside its limits; one line with file, key and remedy.
    """
    if not isinstance(data, Mapping):
        raise ConfigError(f"{where or 'configuration'}: expected keys and values, got {_describe(data)}")
    hints = _hints(cls)
    known = {f.name: f for f in dataclasses.fields(cls)}
    for key in data:
        if key not in known:
            raise ConfigError(f"{at(where, str(key))}: unknown key; {_suggest(str(key), list(known))}")
    values = {}
    for name, declared in known.items():
        if name in data:
            values[name] = _convert(hints[name], data[name], at(where, name), settings_of(cls).get(name))
        elif declared.default is dataclasses.MISSING and declared.default_factory is dataclasses.MISSING:
            about = settings_of(cls).get(name)
            raise ConfigError(f"{at(where, name)}: missing; add it ({about.help if about else 'required'})")
    try:
        return cls(**values)
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}" if where else str(error)) from None


def dump_config(config: Config) -> dict[str, Plain]:
    """Return plain data from which `load_config` makes an equal configuration."""
    return {f.name: _plain(getattr(config, f.name)) for f in dataclasses.fields(config)}


def with_setting(data: dict[str, Any], key: str, value: object, where: str) -> None:
    """Set one dotted `key` in nested plain data, in place.

    Raises
    ------
    ConfigError
        If a part of the key leads through something that is not a section.
    """
    *parents, last = key.split(".")
    for parent in parents:
        data = data.setdefault(parent, {})
        if not isinstance(data, dict):
            raise ConfigError(f"{where}: '{parent}' in '{key}' is a single value, not a section with keys")
    data[last] = value


def dotted_keys(cls: type[Config], prefix: str = "") -> dict[str, tuple[Any, Setting]]:
    """Return every leaf setting under `cls` by dotted key, with its type and meaning."""
    hints, leaves = _hints(cls), {}
    for f in dataclasses.fields(cls):
        key = f"{prefix}{f.name}"
        if isinstance(hints[f.name], type) and issubclass(hints[f.name], Config):
            leaves.update(dotted_keys(hints[f.name], f"{key}."))
        else:
            leaves[key] = (hints[f.name], settings_of(cls).get(f.name, Setting("")))
    return leaves


def full_key(cls: type[Config], key: str, where: str) -> str:
    """Return the one dotted key that ends in `key`, so that people may write ``lps.mode`` for ``agent.lps.mode``.

    Raises
    ------
    ConfigError
        If no key, or more than one, ends so.
    """
    keys = list(dotted_keys(cls))
    if key in keys:
        return key
    fits = [k for k in keys if k.endswith(f".{key}")]
    if len(fits) == 1:
        return fits[0]
    if fits:
        raise ConfigError(f"{where}: '{key}' could be {' or '.join(fits)}; write one of them in full")
    raise ConfigError(f"{where}: unknown key '{key}'; {_nearest_key(key, keys)}")


def _nearest_key(word: str, keys: list[str]) -> str:
    """Return the remedy for an unknown dotted key: the one that ends most like it, or in a word most like its last."""
    endings = {".".join(parts[k:]): key for key in keys for parts in [key.split(".")] for k in range(len(parts))}
    for wanted in (word, word.rpartition(".")[2]):
        near = difflib.get_close_matches(wanted, list(endings), n=1, cutoff=0.7)
        if near:
            return f"did you mean '{endings[near[0]]}'?"
    return "scripts/launch_swarm.py --explain prints all keys"


def at(where: str, key: str) -> str:
    """Return the place of `key` in an error: ``file.yaml: section.key``."""
    if not where:
        return key
    return f"{where}.{key}" if ": " in where else f"{where}: {key}"


def _hints(cls: type) -> dict[str, Any]:
    return typing.get_type_hints(cls)


def _convert(hint: Any, value: object, where: str, about: Setting | None) -> Any:  # noqa: PLR0911 - a case each
    """Check `value` against a type hint and return it as that type."""
    origin = typing.get_origin(hint)
    if origin in (types.UnionType, typing.Union):
        if value is None:
            return None
        (inner,) = [arg for arg in typing.get_args(hint) if arg is not type(None)]
        return _convert(inner, value, where, about)
    if origin is dict:
        if not isinstance(value, Mapping):
            raise ConfigError(f"{where}: expected keys and values, got {_describe(value)}")
        return {str(key): item for key, item in value.items()}  # what it holds is for others to check
    if origin is tuple:
        return _convert_tuple(typing.get_args(hint), value, where, about)
    if isinstance(hint, type) and issubclass(hint, Config):
        return load_config(hint, value, where)
    if isinstance(hint, type) and issubclass(hint, Enum):
        choices = [str(member.value) for member in hint]
        if value not in choices:
            raise ConfigError(f"{where}: got {_describe(value)}; {_suggest(str(value), choices)}")
        return hint(value)
    return _convert_scalar(hint, value, where, about)


def _convert_tuple(args: tuple[Any, ...], value: object, where: str, about: Setting | None) -> tuple[Any, ...]:
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise ConfigError(f"{where}: expected a list, got {_describe(value)}")
    if args[-1] is Ellipsis:
        kinds = [args[0]] * len(value)
    elif len(args) != len(value):
        raise ConfigError(f"{where}: expected {len(args)} values, got {len(value)}")
    else:
        kinds = list(args)
    return tuple(
        _convert(kind, item, f"{where}[{index}]", about)
        for index, (kind, item) in enumerate(zip(kinds, value, strict=True))
    )


def _convert_scalar(hint: Any, value: object, where: str, about: Setting | None) -> Any:
    names = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}
    fits = isinstance(value, (int, float) if hint is float else hint) and (hint is bool or not isinstance(value, bool))
    if not fits:
        raise ConfigError(f"{where}: expected {names[hint]}, got {_describe(value)}")
    if isinstance(value, int | float) and not isinstance(value, bool) and about and not about.allows(float(value)):
        wanted = about.limits() or "a finite number"
        raise ConfigError(f"{where}: must be {wanted}, got {value:g}")
    return float(value) if hint is float else value  # type: ignore[arg-type]


def _plain(value: object) -> Plain:
    if isinstance(value, Config):
        return dump_config(value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"{type(value).__name__} has no plain form")


def _describe(value: object) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, Mapping):
        return "keys and values"
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, Sequence):
        return "a list"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _suggest(word: str, known: list[str]) -> str:
    """Return the remedy for an unknown word: the nearest known one, or all of them."""
    near = difflib.get_close_matches(word, known, n=1)
    return f"did you mean '{near[0]}'?" if near else f"choose from: {', '.join(sorted(known))}"
