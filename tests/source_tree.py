"""Reads the project's own source as syntax trees, for the tests of its structure."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SRC = ROOT / "ros_ws" / "src"
PACKAGES = ("swarm_msgs_py", "swarm_agent", "mission_computer", "swarm_sim")
ACTORS = PACKAGES[1:]


@dataclass(frozen=True)
class Module:
    """One Python file: its dotted name, where it is, and what is written in it."""

    name: str
    path: Path
    tree: ast.Module

    @property
    def place(self) -> str:
        """Path as a person would look it up."""
        return str(self.path.relative_to(ROOT))

    @property
    def package(self) -> str:
        """First part of the name."""
        return self.name.partition(".")[0]

    @property
    def is_ros_adapter(self) -> bool:
        """Whether it lives in a ``ros`` folder, the only home of ROS imports."""
        return "ros" in self.name.split(".")[1:]


def read_modules(base: Path, folder: Path) -> dict[str, Module]:
    """Return the modules under `folder` by dotted name as seen from `base`."""
    found = {}
    for path in sorted(folder.rglob("*.py")):
        parts = path.relative_to(base).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = Module(name, path, ast.parse(path.read_text(encoding="utf-8"), str(path)))
    return found


@cache
def package_modules() -> dict[str, Module]:
    """Return every module of the four packages."""
    return {
        name: module
        for package in PACKAGES
        for name, module in read_modules(SRC / package, SRC / package / package).items()
    }


@cache
def script_modules() -> dict[str, Module]:
    """Return every module under ``scripts``."""
    return read_modules(ROOT / "scripts", ROOT / "scripts")


def modules_of(package: str) -> list[Module]:
    """Return the modules of one package, in order of name."""
    return [module for module in package_modules().values() if module.package == package]


def imports(module: Module) -> set[str]:
    """Return what a module imports, anywhere in it: modules where they are known as such, else what they come from."""
    known = package_modules().keys() | script_modules().keys()
    found = set()
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            source = _absolute(module, node)
            names = {f"{source}.{alias.name}" for alias in node.names}
            found |= {name if name in known else source for name in names}
    return found


def imported_packages(module: Module) -> set[str]:
    """Return the first parts of all names that a module imports."""
    return {name.partition(".")[0] for name in imports(module)}


def _absolute(module: Module, node: ast.ImportFrom) -> str:
    if not node.level:
        return node.module or ""
    is_package = module.path.name == "__init__.py"
    parents = module.name.split(".")[: len(module.name.split(".")) - node.level + is_package]
    return ".".join([*parents, *([node.module] if node.module else [])])


def calls(module: Module) -> Iterator[tuple[int, str]]:
    """Yield line and full dotted name of every call, with import aliases resolved."""
    aliases = {}
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Import):
            aliases |= {
                alias.asname or alias.name.partition(".")[0]: alias.name for alias in node.names if alias.asname
            }
        elif isinstance(node, ast.ImportFrom):
            aliases |= {alias.asname or alias.name: f"{_absolute(module, node)}.{alias.name}" for alias in node.names}
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Call):
            first, dot, rest = _dotted(node.func).partition(".")
            yield node.lineno, aliases.get(first, first) + dot + rest


def _dotted(node: ast.expr) -> str:
    if isinstance(node, ast.Name):
        return node.id
    return f"{_dotted(node.value)}.{node.attr}" if isinstance(node, ast.Attribute) else "?"


def is_ros(package: str) -> bool:
    """Return whether a top-level name belongs to ROS: the client library, its tools, or a message package."""
    return package in {"rclpy", "ament_index_python", "rpyutils", "std_srvs"} or (
        package.endswith(("_msgs", "_interfaces")) and package not in PACKAGES
    )
