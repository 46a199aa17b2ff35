"""The rules of the architecture, checked on the syntax trees: who imports whom, and what no module may do."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from collections.abc import Iterator

import pytest
from source_tree import (
    ACTORS,
    PACKAGES,
    ROOT,
    Module,
    calls,
    imported_packages,
    imports,
    is_ros,
    modules_of,
    package_modules,
    script_modules,
)

PYBULLET_HOME = "swarm_sim.bullet"
PYBULLET_USERS = {
    *("swarm_sim.world.pybullet_world", "swarm_sim.world.pybullet_boats", "swarm_sim.camera.bullet_painter")
}
RANDOMNESS_HOME = "swarm_msgs_py.randomness"  # where named random streams are derived
CLOCKS = ("time", "datetime")  # simulated time arrives as an argument
GENERATORS = {"Generator", "SeedSequence", "PCG64", "BitGenerator"}
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
NAMELESS = {"utils", "util", "helpers", "helper", "common", "misc"}
Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@pytest.mark.parametrize("package", ACTORS)
def test_an_actor_package_imports_no_package_of_the_project_but_the_shared_one(package: str) -> None:
    foreign = {*PACKAGES, "bringup"} - {package, "swarm_msgs_py"}
    assert_none(
        f"{module.place} imports {name}"
        for module in modules_of(package)
        for name in imports(module)
        if _in(name, foreign)
    )


def test_the_shared_package_imports_no_actor() -> None:
    assert_none(
        f"{module.place} imports {name}"
        for module in modules_of("swarm_msgs_py")
        for name in imports(module)
        if _in(name, {*ACTORS, "bringup"})
    )


def test_ros_is_imported_only_by_ros_adapters() -> None:
    everywhere = [*package_modules().values(), *script_modules().values()]
    assert_none(
        f"{module.place} imports {name}"
        for module in everywhere
        if not module.is_ros_adapter
        for name in imported_packages(module)
        if is_ros(name)
    )


@pytest.mark.parametrize("package", PACKAGES)
def test_the_core_of_a_package_does_not_import_its_ros_adapters(package: str) -> None:
    adapters = {module.name for module in package_modules().values() if module.is_ros_adapter}
    assert_none(
        f"{module.place} imports {name}"
        for module in modules_of(package)
        if not module.is_ros_adapter
        for name in imports(module) & adapters
    )


def test_pybullet_is_used_only_by_worlds_and_by_the_camera() -> None:
    everywhere = [*package_modules().values(), *script_modules().values()]
    assert_none(
        f"{module.place} imports pybullet"
        for module in everywhere
        if module.name != PYBULLET_HOME
        for name in imported_packages(module)
        if name.startswith("pybullet")
    )
    assert_none(
        f"{module.place} imports {PYBULLET_HOME}"
        for module in everywhere
        if module.name not in PYBULLET_USERS and PYBULLET_HOME in imports(module)
    )


@pytest.mark.parametrize("entry", ["bringup.inprocess", "launch_swarm"])
def test_a_run_in_one_process_imports_with_ros_out_of_reach(entry: str) -> None:
    program = f"""
import importlib, importlib.abc, sys
sys.path.insert(0, {str(ROOT / "scripts")!r})
class NoRos(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        root = name.partition(".")[0]
        if root in ("rclpy", "std_srvs") or root.endswith(("_msgs", "_interfaces")):
            raise ModuleNotFoundError(f"No module named '{{root}}'", name=root)
sys.meta_path.insert(0, NoRos())
importlib.import_module({entry!r})
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("package", [*PACKAGES, "scripts"])
def test_modules_import_each_other_without_a_cycle(package: str) -> None:
    modules = list(script_modules().values()) if package == "scripts" else modules_of(package)
    names = {module.name for module in modules}
    graph = {module.name: (imports(module) & names) - {module.name} for module in modules}

    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        pytest.fail("import cycle: " + " <- ".join(error.args[1]))


def test_everything_public_has_a_docstring() -> None:
    everywhere = [*package_modules().values(), *script_modules().values()]
    nodes = [
        (module, node, getattr(node, "name", "the module"))
        for module in everywhere
        for node in (module.tree, *_public(module.tree.body))
    ]
    assert_none(f"{module.place}: {name}" for module, node, name in nodes if not ast.get_docstring(node))


def test_the_core_reads_no_clock() -> None:
    assert_none(
        f"{module.place} imports {name}"
        for module in _core()
        for name in sorted(imported_packages(module))
        if name in CLOCKS
    )


def test_the_core_draws_random_numbers_only_from_named_streams() -> None:
    assert_none(
        f"{module.place} uses {name}"
        for module in _core()
        for name in {*imports(module), *(name for _, name in calls(module))}
        if name.partition(".")[0] == "random"
        or (name.startswith(("np.random.", "numpy.random.")) and not _may_draw(module, name.rpartition(".")[2]))
    )


def test_packages_do_not_print() -> None:
    assert_none(
        f"{module.place}:{line}"
        for module in package_modules().values()
        for line, name in calls(module)
        if name in {"print", "sys.stdout.write", "sys.stderr.write"}
    )


def test_files_and_functions_stay_small() -> None:
    everywhere = [*package_modules().values(), *script_modules().values()]
    lengths = {module.place: len(module.path.read_text(encoding="utf-8").splitlines()) for module in everywhere}
    tests = {
        str(path.relative_to(ROOT)): len(path.read_text(encoding="utf-8").splitlines())
        for path in (ROOT / "tests").rglob("*.py")
    }
    assert_none(f"{place} has {n} lines" for place, n in (lengths | tests).items() if n > MAX_FILE_LINES)
    assert_none(
        f"{module.place}:{node.lineno} {node.name} has {length} lines"
        for module in everywhere
        for node in ast.walk(module.tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (length := _code_lines(node)) > MAX_FUNCTION_LINES
    )


def test_every_file_is_named_after_what_it_holds() -> None:
    folders = (ROOT / "ros_ws" / "src", ROOT / "scripts", ROOT / "tests", ROOT / "benchmarks")
    paths = [path for folder in folders for path in folder.rglob("*") if path.suffix == ".py" or path.is_dir()]
    assert_none(str(path.relative_to(ROOT)) for path in paths if path.stem in NAMELESS)


def test_every_folder_of_a_package_is_a_package() -> None:
    assert_none(
        f"{module.path.parent.relative_to(ROOT)} has no __init__.py"
        for module in package_modules().values()
        if not (module.path.parent / "__init__.py").exists()
    )


def assert_none(violations: Iterator[str]) -> None:
    """Fail with one line per violation, each once."""
    found = sorted(set(violations))
    assert not found, "\n".join(["", *found])


def _core() -> list[Module]:
    return [module for module in package_modules().values() if not module.is_ros_adapter]


def _may_draw(module: Module, function: str) -> bool:
    return function in GENERATORS or module.name == RANDOMNESS_HOME


def _in(name: str, packages: set[str]) -> bool:
    return name.partition(".")[0] in packages


def _public(body: list[ast.stmt]) -> Iterator[Definition]:
    """Yield public classes, functions and methods; not what is defined inside a function."""
    for node in body:
        if isinstance(node, Definition) and not node.name.startswith("_") and not _is_property_setter(node):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from _public(node.body)


def _is_property_setter(node: Definition) -> bool:
    """Return whether the docstring stands elsewhere: at the getter."""
    return any(isinstance(mark, ast.Attribute) and mark.attr == "setter" for mark in node.decorator_list)


def _code_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the length of a function without its docstring."""
    doc = node.body[0] if ast.get_docstring(node, clean=False) is not None else None
    documented = doc.end_lineno - doc.lineno + 1 if doc is not None and doc.end_lineno else 0
    return (node.end_lineno or node.lineno) - node.lineno + 1 - documented
