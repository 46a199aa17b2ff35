"""Classes that others add: installed packages name them as entry points, settings choose them by that name."""

from __future__ import annotations

import difflib
from importlib.metadata import EntryPoint, entry_points

from swarm_msgs_py.errors import ConfigError

PARTITION_METHODS = "swarm.partition_methods"
"""Group of `swarm_msgs_py.partition.method.PartitionMethod` classes, made with a `PartitionConfig`."""

STRATEGIES = "swarm.strategies"
"""Group of `swarm_agent.decision.strategy.Strategy` classes, made with `swarm_agent.decision.strategy.Means`."""


GROUPS = (PARTITION_METHODS, STRATEGIES)


def extension_points() -> tuple[EntryPoint, ...]:
    """Return what installed packages add to all groups, by group and name."""
    found = {point for group in GROUPS for point in entry_points(group=group)}
    return tuple(sorted(found, key=lambda point: (point.group, point.name, point.value)))


def extension_names(group: str) -> tuple[str, ...]:
    """Return the names of all extensions of a group, in alphabetical order."""
    return tuple(sorted({point.name for point in entry_points(group=group)}))


def extension(group: str, name: str) -> type:
    """Return the class that an installed package adds to a group under a name.

    Raises
    ------
    ConfigError
        If there is none, more than one, or it cannot be loaded.
    """
    found = [point for point in entry_points(group=group) if point.name == name]
    if not found:
        known = extension_names(group)
        near = difflib.get_close_matches(name, known, n=1)
        remedy = f"did you mean '{near[0]}'?" if near else f"installed are: {', '.join(known) or 'none'}"
        raise ConfigError(f"no installed package adds '{name}' to {group}; {remedy}")
    if len({point.value for point in found}) > 1:
        places = " and ".join(sorted({point.value for point in found}))
        raise ConfigError(f"'{name}' in {group} is added twice, by {places}; uninstall one of them")
    return _loaded(found[0], group)


def _loaded(point: EntryPoint, group: str) -> type:
    try:
        loaded = point.load()
    except Exception as error:  # noqa: BLE001 - whatever is wrong with a researcher's module, one line tells it
        why = f"{type(error).__name__}: {error}"
        raise ConfigError(f"'{point.name}' in {group} cannot be loaded from {point.value} ({why})") from None
    if not isinstance(loaded, type):
        raise ConfigError(f"'{point.name}' in {group} is not a class: {point.value}; name a class there")
    return loaded
