"""Parts of command lines that several scripts share: one-line errors with a remedy, and checked values."""

from __future__ import annotations

import argparse
import difflib
import math
import re
import sys
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import NoReturn

from bringup.steady_stream import steady
from swarm_msgs_py.errors import ConfigError


class OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line, with a remedy, as everything else here does."""

    def error(self, message: str) -> NoReturn:
        """Refuse the command line.

        Raises
        ------
        ConfigError
        """
        match = re.match(r"unrecognized arguments: (\S+)", message)
        if match:
            options = [option for action in self._actions for option in action.option_strings]
            near = difflib.get_close_matches(match[1].partition("=")[0], options, n=1)
            remedy = f"did you mean '{near[0]}'?" if near else "see --help for all options"
            raise ConfigError(f"{match[1]}: unknown option; {remedy}")
        raise ConfigError(message.removeprefix("argument ").replace("\n", " "))


def complain(error: Exception) -> None:
    """Tell the operator what is wrong, in one line."""
    print(f"error: {' '.join(str(error).split())}", file=steady(sys.stderr))


def whole(minimum: int, maximum: int) -> Callable[[str], int]:
    """Return a parser of whole numbers in a range."""

    def parse(text: str) -> int:
        if not re.fullmatch(r"[+-]?\d+", text) or not minimum <= int(text) <= maximum:
            raise argparse.ArgumentTypeError(f"expected a whole number from {minimum} to {maximum}, got '{text}'")
        return int(text)

    return parse


def number(minimum: float, maximum: float) -> Callable[[str], float]:
    """Return a parser of numbers in a range."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not minimum <= value <= maximum:
            raise argparse.ArgumentTypeError(f"expected a number from {minimum:g} to {maximum:g}, got '{text}'")
        return value

    return parse


def choice(kind: type[Enum], *others: str) -> Callable[[str], str]:
    """Return a parser of the values of an enumeration, and of other words, which knows what was meant."""
    known = [*(str(member.value) for member in kind), *others]

    def parse(text: str) -> str:
        if text not in known:
            near = difflib.get_close_matches(text, known, n=1)
            remedy = f"did you mean '{near[0]}'?" if near else f"choose from: {', '.join(known)}"
            raise argparse.ArgumentTypeError(f"there is no '{text}'; {remedy}")
        return text

    return parse


def folder(text: str) -> Path:
    """Return the path of a folder that was named."""
    if not text.strip():
        raise argparse.ArgumentTypeError("expected a folder, got ''")
    return Path(text)
