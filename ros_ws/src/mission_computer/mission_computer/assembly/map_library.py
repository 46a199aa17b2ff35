"""Assembly problems from where the operator has them: maps of the package, or files."""

from __future__ import annotations

from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from mission_computer.shape.library import suggestion
from swarm_msgs_py.assembly.faces import Gender
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.assembly.problem_file import parse_problem
from swarm_msgs_py.errors import AssemblyError

FILE_BYTES_MAX = 10_000_000
"""More is a wrong file, not a map."""


@cache
def map_names() -> tuple[str, ...]:
    """Return the names of all maps of the package, in alphabetical order."""
    return tuple(sorted(f.name.removesuffix(".json") for f in _folder().iterdir() if f.name.endswith(".json")))


def load_problem(source: str | Path, gender: Gender) -> AssemblyProblem:
    """Return the problem that a map of the package or a file describes.

    Parameters
    ----------
    source : str or path
        Name of a map, or path of a JSON file.
    gender : Gender
        Which docking mechanisms the boats have.

    Raises
    ------
    AssemblyError
        One line that names the source, what is wrong and what to do.
    """
    if str(source) in map_names():
        return parse_problem((_folder() / f"{source}.json").read_text(encoding="utf-8"), str(source), gender)
    path = Path(source)
    if not path.is_file():
        raise AssemblyError(f"map '{source}' is neither a map nor a file; {suggestion(str(source), map_names())}")
    try:
        if path.stat().st_size > FILE_BYTES_MAX:
            raise AssemblyError(f"{path}: larger than {FILE_BYTES_MAX} bytes; that is no map")
        return parse_problem(path.read_text(encoding="utf-8"), str(path), gender)
    except (OSError, UnicodeDecodeError) as error:
        raise AssemblyError(f"{path}: cannot be read ({error})") from None


def _folder() -> Traversable:
    return resources.files("mission_computer") / "assembly" / "maps"
