"""The workspace builds with colcon, and what it installs starts on its own."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from source_tree import PACKAGES, SRC

NODES = {"swarm_agent": "agent_node", "mission_computer": "mission_node", "swarm_sim": "world_node"}
START_S = 30.0  # generous: a cold import of everything on a busy machine
STOP_S = 20.0


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


def test_the_build_installs_launch_files_and_settings_of_viewers(install: Path) -> None:
    source, share = SRC / "swarm_bringup", install / "swarm_bringup" / "share"
    wanted = {path.relative_to(source) for path in source.glob("*/*") if path.parent.name in {"launch", "config"}}

    assert len(wanted) == 5
    assert {path for path in wanted if not (share / "swarm_bringup" / path).is_file()} == set()
    assert (share / "ament_index" / "resource_index" / "packages" / "swarm_bringup").is_file()


@pytest.mark.needs_ros
@pytest.mark.parametrize("package", NODES)
def test_an_installed_node_joins_the_graph_and_ends_at_ctrl_c(
    install: Path, package: str, others_on_graph: Callable[[], set[str]]
) -> None:
    libraries = [str(path) for path in install.glob("*/lib/python*/site-packages")]
    process = subprocess.Popen(
        [str(install / package / "lib" / package / NODES[package])],
        env=os.environ
        | {"PYTHONPATH": os.pathsep.join([*libraries, os.environ.get("PYTHONPATH", "")]).strip(os.pathsep)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        deadline = time.monotonic() + START_S
        while not (joined := others_on_graph()) and process.poll() is None and time.monotonic() < deadline:
            pass  # each look at the graph waits a little
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=STOP_S)
    finally:
        process.kill()
        process.wait()

    assert joined, output
    assert "Traceback" not in output
    assert process.returncode in {0, 130}, output


@pytest.fixture
def others_on_graph(domain_id: int) -> Iterator[Callable[[], set[str]]]:
    """Return a function that spins briefly and tells which nodes share this test's domain."""
    rclpy = pytest.importorskip("rclpy")
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    observer = rclpy.create_node("observer", context=context, enable_rosout=False, start_parameter_services=False)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(observer)

    def look() -> set[str]:
        executor.spin_once(timeout_sec=0.1)
        return set(observer.get_node_names()) - {"observer"}

    yield look
    executor.shutdown()
    observer.destroy_node()
    rclpy.shutdown(context=context)


def test_the_sources_are_what_the_virtual_environment_imports() -> None:
    program = f"import {', '.join(PACKAGES)}; print(*(m.__path__[0] for m in ({', '.join(PACKAGES)})), sep='\\n')"
    found = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True, cwd="/"
    )

    assert [Path(line) for line in found.stdout.split("\n") if line] == [SRC / name / name for name in PACKAGES]
