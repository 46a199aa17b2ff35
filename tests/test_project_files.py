"""What the project says of itself outside the code must be true: package metadata, requirements, README."""

from __future__ import annotations

import argparse
import ast
import importlib
import re
import shlex
import sys
import tomllib
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

import pytest
from documented_commands import LAUNCHER, documents, inline_spans, shell_commands
from orders import order_cli
from source_tree import PACKAGES, ROOT, SRC, Module, imported_packages, is_ros, modules_of, script_modules

from batches import arguments as batch_arguments
from batches.cells import cells
from bringup import arguments
from bringup.formation_kind import METHODS, FormationKind
from bringup.scenario import Scenario
from bringup.scenario_file import load_any, load_scenario, parse_assignment
from docs_site.reference import PATHS
from previews import shape_cli
from recording import replay_cli
from reports import plot_cli
from studies import camera_cli, coverage_experiments, lps_arguments
from swarm_msgs_py.config import full_key
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.extensions import PARTITION_METHODS

REQUIREMENTS = sorted((ROOT / "requirements").glob("*.txt"))
PIN = re.compile(r"[a-z0-9][a-z0-9-]*==[0-9][0-9a-z.]*")

ROSDEP_KEYS = {
    "PIL": "python3-pil",
    "contourpy": "python3-matplotlib",  # which brings it
    "cv2": "python3-opencv",
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "pybullet": "python3-pybullet-pip",
    "scipy": "python3-scipy",
    "shapely": "python3-shapely",
    "trimesh": "python3-trimesh-pip",
    "yaml": "python3-yaml",
}
"""Name to import -> key in the rosdep database."""

NOT_IN_ROSDEP = frozenset({"ortools", "svgelements"})
"""Names to import without a key there; one that does not exist would stop `rosdep install` for all packages."""

INDEX_NAMES = {
    "PIL": "pillow",
    "cv2": "opencv-python-headless",
    "foxglove": "foxglove-sdk",
    "imageio_ffmpeg": "imageio-ffmpeg",
    "yaml": "PyYAML",
}
"""Name to import -> name on the package index, where they differ."""


@pytest.mark.parametrize("package", PACKAGES)
def test_package_xml_declares_exactly_what_the_package_imports(package: str) -> None:
    root = ET.parse(SRC / package / "package.xml").getroot()
    declared = {element.text for element in root.findall("exec_depend")}

    assert root.get("format") == "3"
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"
    assert root.findtext("export/build_type") == "ament_python"
    needed = foreign(package) - NOT_IN_ROSDEP
    assert declared == {name if is_ros(name) or name in PACKAGES else ROSDEP_KEYS[name] for name in needed}


@pytest.mark.parametrize("package", PACKAGES)
def test_setup_py_requires_exactly_what_the_package_imports_from_the_index(package: str) -> None:
    text = (SRC / package / "setup.py").read_text(encoding="utf-8")
    listed = re.search(r"install_requires=\[(.*?)\]", text, re.DOTALL)

    assert listed is not None
    assert set(re.findall(r'"(.+?)"', listed[1])) == {
        INDEX_NAMES.get(name, name) for name in foreign(package) if not is_ros(name)
    }


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_has_one_version_everywhere(package: str) -> None:
    version = ET.parse(SRC / package / "package.xml").findtext("version")

    assert f'version="{version}"' in (SRC / package / "setup.py").read_text(encoding="utf-8")
    assert f'version = "{version}"' in (ROOT / "pyproject.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", REQUIREMENTS, ids=lambda path: path.name)
def test_requirements_are_pinned_and_come_from_no_named_place(path: Path) -> None:
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]

    assert lines
    assert [line for line in lines if not PIN.fullmatch(line)] == []


def test_a_distribution_has_one_version_in_all_requirements_files() -> None:
    pins = {line for path in REQUIREMENTS for line in path.read_text(encoding="utf-8").splitlines() if "==" in line}
    names = [pin.partition("==")[0] for pin in pins]

    assert sorted(names) == sorted(set(names))


def test_all_that_the_scripts_import_is_pinned() -> None:
    pinned = {line.partition("==")[0] for line in (ROOT / "requirements" / "base.txt").read_text().splitlines()}
    own = {*PACKAGES, "bringup", *script_modules()}
    needed = {
        name
        for module in script_modules().values()
        for name in imported_packages(module) - own
        if not is_standard(name)
    }

    assert {INDEX_NAMES.get(name, name).lower() for name in needed if not is_ros(name)} <= pinned


def test_every_run_time_distribution_stands_in_the_licence_table() -> None:
    table = (ROOT / "docs" / "licenses.md").read_text(encoding="utf-8")
    runtime = [(ROOT / "requirements" / name).read_text(encoding="utf-8") for name in ("base.txt", "ros.txt")]
    names = {line.partition("==")[0] for text in runtime for line in text.splitlines() if "==" in line}

    assert sorted(name for name in names if f"`{name}`" not in table) == []


def test_every_make_target_in_the_documents_exists() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    named = {words[1] for words in shell_commands() if words[0] == "make" and len(words) > 1}

    assert named
    assert named <= targets


def test_every_command_in_the_documents_would_be_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    methods = (*METHODS, *example_methods())  # as where the examples are installed
    monkeypatch.setattr(FormationKind, "methods", methods)
    monkeypatch.setattr(shape_cli, "METHODS", methods)
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    commands = [found for words in [*shell_commands(), *inline_commands()] if (found := script_command(words))]

    for script, words in commands:
        take(script, words, monkeypatch)
    assert {script for script, words in commands if words} >= {
        *("scripts/launch_swarm.py", "scripts/lps_study.py", "scripts/monte_carlo.py"),
        *("benchmarks/formation.py", "benchmarks/robustness.py", "benchmarks/mesh_delivery.py"),
    }


@pytest.mark.parametrize(
    "line",
    [
        "make run ARGS='--scenario nowhere'",
        "make run ARGS='--set no_such_key=0.5'",
        "make run ARGS='--set radio.loss=2'",
        "scripts/launch_swarm.py --nonsense",
        "scripts/lps_study.py --nonsense",
        "scripts/lps_study.py --modes gps",
        "scripts/monte_carlo.py --method bubbles",
        "scripts/monte_carlo.py --seeds many",
        "scripts/no_such_script.py",
        "scripts/shape.py formation_1 --method nothing",
        "benchmarks/formation.py --nonsense",
        "benchmarks/robustness.py nonsense",
        "scripts/plot_run.py RUN --fsp 3",
        "scripts/replay.py RUN --rate fast",
        "benchmarks/robustness.py --set radio.lost=0.1",
        "benchmarks/mesh_delivery.py --seeds many",
        "benchmarks/bench_world.py --nonsense",
        "--set no_such_key=1",
        "--set no_such_key=",
    ],
)
def test_a_command_with_a_mistake_would_be_found(line: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    command = script_command(shlex.split(line))

    assert command is not None
    with pytest.raises((ConfigError, SystemExit, AssertionError)):
        take(*command, monkeypatch)


def test_links_between_documents_lead_somewhere() -> None:
    generated = {(ROOT / "docs" / page).resolve() for page in PATHS}
    broken = [
        f"{path.relative_to(ROOT)} -> {target}"
        for path in documents()
        for target in re.findall(r"\]\((?!https?:)([^)#\s]+)", path.read_text(encoding="utf-8"))
        if not (path.parent / target).exists() and (path.parent / target).resolve() not in generated
    ]

    assert broken == []


def inline_commands() -> list[list[str]]:
    """Return the Python commands and the settings that stand between backticks in running text, as words."""
    return [shlex.split(span) for span in inline_spans() if ".py " in f"{span} " or span.startswith("--set ")]


def script_command(words: Sequence[str]) -> tuple[str, list[str]] | None:
    """Return the script of this project that a command starts, and the words after it; None: it starts another thing.

    `make run ARGS="..."` starts the launcher, and what is only ``--set key=value`` is meant for it.
    """
    if words[0] == "--set":
        return LAUNCHER, list(words)
    if words[:2] == ["make", "run"]:
        handed = [word.partition("=")[2] for word in words[2:] if word.startswith("ARGS=")]
        return LAUNCHER, [part for text in handed for part in shlex.split(text)]
    for place, word in enumerate(words):
        if re.fullmatch(r"(scripts|benchmarks)/\w+\.py", word):
            return word, [other for other in words[place + 1 :] if other != "..."]  # as in `--seeds 1 2 ... 20`
    return None


def take(script: str, words: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a script read its command line, and nothing more; settings must fit the scenario that they are for.

    Raises
    ------
    ConfigError, SystemExit, AssertionError
        If it would not take it.
    """
    assert (ROOT / script).is_file(), script
    if script == LAUNCHER:
        take_launch([word for word in words if word not in {"--help", "key=value"}])
    elif script == "scripts/lps_study.py":
        lps_arguments.parse_arguments(words)
    elif script == "scripts/plot_run.py":
        plot_cli.parse_arguments(words or ["RUN"])
    elif script == "scripts/replay.py":
        replay_cli.parse_arguments(words or ["RUN"])
    elif script == "scripts/order.py":
        order_cli.parse_arguments(words or ["pause"])
    elif script == "scripts/shape.py":
        shape_cli.parse_arguments([word for word in words if word != "--help"])
    elif script == "scripts/camera_study.py":
        camera_cli.parse_arguments(words)
    elif script == "scripts/coverage_study.py":
        coverage_experiments.parsed(words)
    elif script == "scripts/monte_carlo.py":
        cells(batch_arguments.parse_arguments(words).design)
    elif "ArgumentParser" not in (ROOT / script).read_text("utf-8"):
        assert words == [], f"{script} has no options"
    else:
        given = parsed_by(Path(script).stem, words, monkeypatch)
        for text in getattr(given, "settings", []):
            load_scenario("formation-50", (parse_assignment(text),))


def take_launch(words: Sequence[str]) -> None:
    """Read a command line of the launcher, up to the scenario that it makes."""
    if words and words[-1] == "--set":
        return  # `--set key=value` explains the option
    keys = [word for word in words if word.endswith("=")]  # as in `--set lps.mode=`: values stand elsewhere
    for key in keys:
        assert full_key(Scenario, key[:-1], "--set")
    if not keys:
        given = arguments.parse_arguments(words)
        load_any(given.scenario, given.overrides)


class ParsedError(Exception):
    """Ends a script as soon as its command line was read."""

    def __init__(self, given: argparse.Namespace) -> None:
        super().__init__()
        self.given = given


def parsed_by(module: str, words: Sequence[str], monkeypatch: pytest.MonkeyPatch) -> argparse.Namespace:
    """Return what the parser of a benchmark makes of a command line; the benchmark does not get further.

    Raises
    ------
    SystemExit
        If the parser refuses.
    """
    parse = argparse.ArgumentParser.parse_args

    def parse_and_stop(parser: argparse.ArgumentParser, *_: object) -> None:
        raise ParsedError(parse(parser, words))

    benchmark = importlib.import_module(module)
    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse_and_stop)
    try:
        with pytest.raises(ParsedError) as parsed:
            benchmark.main()
    finally:
        monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse)
    return parsed.value.given


def example_methods() -> list[str]:
    """Return the names of the partition methods that the examples add."""
    projects = [
        tomllib.loads(path.read_text("utf-8"))["project"] for path in (ROOT / "examples").glob("*/pyproject.toml")
    ]
    return sorted(name for project in projects for name in project["entry-points"][PARTITION_METHODS])


def foreign(package: str) -> set[str]:
    """Return the packages that `package` imports or names as the home of an interface, without the standard library."""
    names = {name for module in modules_of(package) for name in imported_packages(module) | interface_packages(module)}
    return {name for name in names if name != package and not is_standard(name)}


def interface_packages(module: Module) -> set[str]:
    """Return the packages of interfaces that a module writes as text, like ``"sensor_msgs/msg/Imu"``."""
    texts = [node.value for node in ast.walk(module.tree) if isinstance(node, ast.Constant)]
    found = [re.fullmatch(r"(\w+)/(?:msg|srv|action)/\w+", text) for text in texts if isinstance(text, str)]
    return {match[1] for match in found if match}


def is_standard(name: str) -> bool:
    """Return whether a package comes with Python."""
    return name in sys.stdlib_module_names
