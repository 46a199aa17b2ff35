"""Who said what of a scenario, so that an error names the place to mend."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from swarm_msgs_py.config import at
from swarm_msgs_py.errors import ConfigError, FrameError, ShapeError

COMMAND_LINE = "command line"


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


@contextmanager
def blamed(origin: Origin, key: str) -> Iterator[None]:
    """Put the place to mend in front of what is wrong with `key`."""
    try:
        yield
    except (ConfigError, ShapeError, FrameError) as error:
        raise ConfigError(f"{origin.of(key)}: {error}") from None
