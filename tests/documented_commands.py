"""The commands that the documents tell people to type."""

from __future__ import annotations

import re
import shlex

from source_tree import ROOT

PAGES = ("README.md", "docs/tutorial.md", "docs/how-to.md")
BLOCK = re.compile(r"^```bash\n(.*?)^```", re.DOTALL | re.MULTILINE)
LAUNCHER = "scripts/launch_swarm.py"


def commands(script: str) -> list[tuple[str, ...]]:
    """Return what follows a script in the shell blocks of the pages, each different one once."""
    found: dict[tuple[str, ...], None] = {}
    for page in PAGES:
        for block in BLOCK.findall((ROOT / page).read_text("utf-8")):
            for line in block.replace("\\\n", " ").splitlines():
                words = shlex.split(line, comments=True)
                if script == LAUNCHER and words[:2] == ["make", "run"]:
                    handed = [word.partition("=")[2] for word in words[2:]]
                    found[tuple(part for text in handed for part in shlex.split(text))] = None
                elif script in words:
                    found[tuple(words[words.index(script) + 1 :])] = None
    return list(found)


def told(words: tuple[str, ...]) -> str:
    """Return a command as a person would read it."""
    return " ".join(words) or "(none)"
