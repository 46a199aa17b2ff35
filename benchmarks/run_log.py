"""Finished runs in a file, one line of JSON each, so that a stopped benchmark goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

Result = dict[str, Any]


class RunLog:
    """Results by key.

    Parameters
    ----------
    path : Path or None
        The file; None: nothing is kept.
    key_of : callable
        Names the run that a result is of.
    """

    def __init__(self, path: Path | None, key_of: Callable[[Result], str]) -> None:
        self._path = path
        self._key_of = key_of
        self.results: dict[str, Result] = {}
        """What the file has, and what was added."""
        if path is None or not path.exists():
            return
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                result = json.loads(line)
            except json.JSONDecodeError:
                continue  # a crash cut it off
            self.results[key_of(result)] = result

    def add(self, result: Result) -> None:
        """Keep a result, and append it to the file."""
        self.results[self._key_of(result)] = result
        if self._path is not None:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(result) + "\n")
