"""The workspace builds with colcon, and what it installs starts on its own."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from source_tree import PACKAGES, ROOT, SRC

pytestmark = pytest.mark.needs_ros

NODES = {"swarm_agent": "agent_node", "mission_computer": "mission_node", "swarm_sim": "world_node"}


@pytest.fixture(scope="module")
def install(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build a copy of the four packages and return the workspace's install folder."""
    workspace = tmp_path_factory.mktemp("ros_ws")
    junk = shutil.ignore_patterns("__pycache__", "build", "*.egg-info")
    shutil.copytree(SRC, workspace / "src", ignore=junk)
    colcon = Path(sys.executable).with_name("colcon")
    command = [str(colcon) if colcon.exists() else "colcon", "build", "--event-handlers", "console_direct+"]
    build = subprocess.run(
        command, cwd=workspace, capture_output=True, text=True, timeout=120, check=False, stdin=subprocess.DEVNULL
    )
    assert build.returncode == 0, build.stdout + build.stderr
    return workspace / "install"


def test_the_build_installs_every_module_and_data_file(install: Path) -> None:
    for package in PACKAGES:
        source = SRC / package / package
        (installed,) = (install / package / "lib").glob(f"python*/site-packages/{package}")
        wanted = {path.relative_to(source) for path in source.rglob("*") if path.suffix in {".py", ".json", ".typed"}}

        assert {path for path in wanted if not (installed / path).exists()} == set()


def test_the_build_registers_every_package_with_the_ament_index(install: Path) -> None:
    for package in PACKAGES:
        share = install / package / "share"

        assert (share / "ament_index" / "resource_index" / "packages" / package).is_file()
        assert (share / package / "package.xml").is_file()


@pytest.mark.parametrize("package", NODES)
def test_an_installed_node_starts_and_ends_at_ctrl_c(install: Path, package: str, domain_id: int) -> None:
    node = install / package / "lib" / package / NODES[package]
    libraries = [str(path) for path in install.glob("*/lib/python*/site-packages")]
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join([*libraries, os.environ.get("PYTHONPATH", "")]).strip(os.pathsep),
        "PYTHONUNBUFFERED": "1",
    }
    process = subprocess.Popen(
        [str(node)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
    )
    try:
        assert process.stdout is not None
        first = process.stdout.readline()  # every node says in one line that it is up
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=20)
    finally:
        process.kill()
        process.wait()

    assert first, f"no line from {node.relative_to(install)} in domain {domain_id}"
    assert "Traceback" not in first + rest
    assert process.returncode in {0, 130, -signal.SIGINT}, first + rest


def test_the_sources_are_what_the_virtual_environment_imports() -> None:
    program = f"import {', '.join(PACKAGES)}; print(*(m.__path__[0] for m in ({', '.join(PACKAGES)})), sep='\\n')"
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True, cwd="/"
    )

    assert [Path(line) for line in found.stdout.split("\n") if line] == [SRC / name / name for name in PACKAGES]
    assert SRC.is_relative_to(ROOT)
