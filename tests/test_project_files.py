"""What the project says of itself outside the code must be true: package metadata, requirements, README."""

from __future__ import annotations

import ast
import re
import shlex
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from source_tree import PACKAGES, ROOT, SRC, Module, imported_packages, is_ros, modules_of, script_modules

REQUIREMENTS = sorted((ROOT / "requirements").glob("*.txt"))
PIN = re.compile(r"[a-z0-9][a-z0-9-]*==[0-9][0-9a-z.]*")

ROSDEP_KEYS = {
    "matplotlib": "python3-matplotlib",
    "numpy": "python3-numpy",
    "pybullet": "python3-pybullet-pip",
    "scipy": "python3-scipy",
    "shapely": "python3-shapely",
    "yaml": "python3-yaml",
}
"""Name to import -> key in the rosdep database."""

INDEX_NAMES = {"yaml": "PyYAML"}
"""Name to import -> name on the package index, where they differ."""


@pytest.mark.parametrize("package", PACKAGES)
def test_package_xml_declares_exactly_what_the_package_imports(package: str) -> None:
    root = ET.parse(SRC / package / "package.xml").getroot()
    declared = {element.text for element in root.findall("exec_depend")}

    assert root.get("format") == "3"
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"
    assert root.findtext("export/build_type") == "ament_python"
    assert declared == {name if is_ros(name) or name in PACKAGES else ROSDEP_KEYS[name] for name in foreign(package)}


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
    named = {words[1] for words in document_commands() if words[0] == "make" and len(words) > 1}

    assert named
    assert named <= targets


def test_every_script_and_option_in_the_documents_exists() -> None:
    # `make run ARGS="--option ..."` hands its words to the launcher, so they are checked as the launcher's.
    commands = [words for words in document_commands() if any("launch_swarm.py" in word for word in words)]
    commands += [shlex.split(word[5:]) for words in document_commands() for word in words if word.startswith("ARGS=")]
    options = {word.partition("=")[0] for words in commands for word in words if word.startswith("--")}
    scenarios = {words[words.index("--scenario") + 1] for words in commands if "--scenario" in words}
    launcher = [sys.executable, str(ROOT / "scripts" / "launch_swarm.py"), "--help"]
    usage = subprocess.run(launcher, capture_output=True, text=True, timeout=60, check=True, stdin=subprocess.DEVNULL)

    assert options
    assert {option for option in options if option not in usage.stdout} == set()
    assert {name for name in scenarios if not (ROOT / "scripts" / "scenarios" / f"{name}.yaml").exists()} == set()


def test_links_between_documents_lead_somewhere() -> None:
    broken = [
        f"{path.relative_to(ROOT)} -> {target}"
        for path in documents()
        for target in re.findall(r"\]\((?!https?:)([^)#\s]+)", path.read_text(encoding="utf-8"))
        if not (path.parent / target).exists()
    ]

    assert broken == []


def documents() -> list[Path]:
    """Return the Markdown files that people read."""
    return sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *SRC.glob("*/README.md")])


def document_commands() -> list[list[str]]:
    """Return the commands in the documents' shell blocks, as words."""
    blocks = [
        block
        for path in documents()
        for block in re.findall(
            r"^```(?:bash|sh|console)\n(.*?)^```", path.read_text("utf-8"), re.DOTALL | re.MULTILINE
        )
    ]
    lines = [line for block in blocks for line in block.replace("\\\n", " ").splitlines()]
    return [words for line in lines if (words := shlex.split(line, comments=True))]


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
