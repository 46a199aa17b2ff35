"""The worked example of docs/extending.md: a package with two methods, installed, run, and swapped for broken ones."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from run_folders import metrics_of
from source_tree import ROOT

EXAMPLE = ROOT / "examples" / "own_methods"
DEADLINE_S = 120.0
FAST = ("--engine", "inprocess", "--physics", "massdamper")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the example with pip, from a copy, and return the folder."""
    folder = tmp_path_factory.mktemp("example")
    copied = shutil.copytree(EXAMPLE, folder / "source", ignore=shutil.ignore_patterns("build", "*.egg-info"))
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check"]
    subprocess.run(
        [sys.executable, "-m", "pip", "install", *options, "--target", str(folder / "site"), str(copied)],
        check=True,
        timeout=DEADLINE_S,
        stdin=subprocess.DEVNULL,
    )
    return folder / "site"


def scripted(site: Path, script: str, *options: str) -> subprocess.CompletedProcess[str]:
    """Run a script with the packages of a folder beside those that are installed."""
    path = os.pathsep.join(filter(None, [os.environ.get("PYTHONPATH", ""), str(site)]))
    return subprocess.run(
        [sys.executable, str(ROOT / "scripts" / script), *options],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
        stdin=subprocess.DEVNULL,
    )


def test_the_swarm_forms_its_shape_by_both_methods_of_the_example(installed: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"

    run = scripted(
        installed, "launch_swarm.py", *FAST, "--method", "sunflower", "--set", "decision.strategy=nearest-free",
        "--out", str(out),
    )  # fmt: skip

    assert run.returncode == 0, run.stdout + run.stderr
    metrics = metrics_of(out)
    assert metrics["method"] == "sunflower"
    assert (metrics["goals_reached"], metrics["collisions"]) == (12, 0)


@pytest.mark.usefixtures("domain_id")
def test_both_methods_move_robots_as_nodes_just_as_in_one_process(installed: Path, tmp_path: Path) -> None:
    both = ("--method", "sunflower", "--set", "mission.task=partition", "--set", "decision.strategy=nearest-free")
    engines = ("inprocess", "ros")
    for engine in engines:
        run = scripted(
            installed, "launch_swarm.py", "--engine", engine, "--physics", "massdamper", *both,
            "--out", str(tmp_path / engine),
        )  # fmt: skip
        assert run.returncode == 0, run.stdout + run.stderr

    alone, nodes = (np.load(tmp_path / engine / "trajectories.npz") for engine in engines)
    assert metrics_of(tmp_path / "ros")["goals_agreed"] is True  # each robot partitioned by the method of the example
    assert np.array_equal(alone["position"], nodes["position"])


def test_the_preview_knows_the_method_of_the_example(installed: Path) -> None:
    run = scripted(installed, "shape.py", "formation_1", "--method", "sunflower")

    assert run.returncode == 0, run.stderr
    assert "robots     50 fit" in run.stdout


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--method", "sunflowers"], "did you mean 'sunflower'?"),
        (["--set", "partition.extension=sunflowers"], "no installed package adds 'sunflowers'"),
        (["--set", "decision.strategy=nearest"], "no installed package adds 'nearest' to swarm.strategies"),
    ],
)
def test_a_method_that_nobody_adds_is_refused_in_one_line(installed: Path, options: list[str], complaint: str) -> None:
    run = scripted(installed, "launch_swarm.py", *FAST, *options)

    assert run.returncode == 2
    assert complaint in run.stderr
    assert run.stderr.count("\n") == 1


def test_an_extension_that_cannot_be_loaded_is_refused_in_one_line(installed: Path, tmp_path: Path) -> None:
    site = shutil.copytree(installed, tmp_path / "site")
    (site / "own_methods" / "sunflower.py").write_text("import no_such_library\n")

    run = scripted(site, "launch_swarm.py", *FAST, "--method", "sunflower")

    assert run.returncode == 2
    assert "'sunflower' in swarm.partition_methods cannot be loaded" in run.stderr
    assert run.stderr.count("\n") == 1
