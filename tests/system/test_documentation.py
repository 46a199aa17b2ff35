"""The documentation site builds without a warning, and what its pages tell people to type does what it says.

Every command of every page has a way in which it is tried (`documented_commands.TRIED`). Here, commands of the launcher
and of batches are run, shortened by `shortened` and `BATCH`: they have fewer robots, and end after some seconds.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from documented_commands import LAUNCHER, TRIED, blocks, commands, how_tried, inline_spans, shell_commands, told
from run_folders import metrics_of
from short_runs import INTERRUPTED, interrupt_after
from source_tree import ROOT

from batches import cli as batch_cli
from bringup import cli
from bringup.kinds import KINDS
from bringup.shape_specs import ShapeSpec
from docs_site.reference import every_channel
from previews import shape_cli
from swarm_msgs_py.config import dotted_keys, load_config

PREVIEW, BATCHES = "scripts/shape.py", "scripts/monte_carlo.py"
ROS_ONLY = {"--real-time", "--dashboard", "--record", "--live"}
"""Options with which a command is run over ROS, in a process of its own; others give the same without it."""
LIGHT = ("--physics", "massdamper")
PHYSICS = {"coverage": ()}
ROBOTS = {"formation": "8", "split": "8", "morph": "3", "sequence": "3"}
"""How many robots the larger formations get."""
OVER_ROS = (*LIGHT, "--set", "success.hold_s=0", "--set", "duration_s=2")
FEW = ("--agents", "4")
OF_FIXED_SIZE = {"arena"}
"""Scenarios that name every robot they have."""
BATCH = ("--seeds", "1", "--agents", "4", "--set", "duration_s=2", "--workers", "1")
SECONDS, ENDS_S = 2.0, 60.0
RAN = {0, 1, INTERRUPTED}  # achieved, not achieved


def shortened(words: tuple[str, ...]) -> list[str]:
    """Return a command of the launcher without ROS, with light physics and few robots; later options win."""
    kept = list(words)
    if "--agents-per-process" in kept:  # without ROS there are no processes
        del kept[kept.index("--agents-per-process") : kept.index("--agents-per-process") + 2]
    kind = kept[kept.index("--scenario") + 1].partition("-")[0] if "--scenario" in kept else "demo"
    few = ROBOTS.get(kind)
    return [*kept, "--engine", "inprocess", *PHYSICS.get(kind, LIGHT), *(("--agents", few) if few else ())]


def is_of_the_example(words: tuple[str, ...]) -> bool:
    """Return whether a command needs the example's methods installed: test_own_methods_example.py runs with them."""
    return "sunflower" in words


def without_ros() -> list[tuple[str, ...]]:
    """Return the commands of the launcher that give the same without ROS."""
    return [words for words in commands(LAUNCHER) if not ROS_ONLY & set(words) and not is_of_the_example(words)]


def over_ros() -> list[tuple[str, ...]]:
    """Return the commands of the launcher that need ROS, one for every set of options for which they do."""
    found = {frozenset(ROS_ONLY & set(words)): words for words in reversed(commands(LAUNCHER))}
    return [words for options, words in found.items() if options]


def test_there_is_a_way_in_which_every_command_is_tried() -> None:
    spans = [span for span in inline_spans() if re.match(r"(PYTHONPATH=scripts )?(\.venv/bin/python|make|ros2) ", span)]
    untried = {" ".join(words) for words in [*shell_commands(), *map(str.split, spans)] if how_tried(words) is None}

    assert len(spans) > 20
    assert untried == set()


@pytest.mark.parametrize(("start", "how"), TRIED.items(), ids=[f"{start}: {how}" for start, how in TRIED.items()])
def test_a_way_of_trying_is_there(start: str, how: str) -> None:
    names = re.findall(r"\S+\.py", how)

    assert all((ROOT / "tests" / name.strip(";,:")).is_file() for name in names), start


@pytest.mark.parametrize("words", without_ros(), ids=told)
def test_commands_of_the_launcher_run(
    words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if "--help" in words:
        with pytest.raises(SystemExit, match="0"):
            cli.main(list(words))
        return
    if "--explain" in words or "--list-scenarios" in words:
        assert cli.main(list(words)) == 0, capsys.readouterr().err
        return
    events = [float(text) for text in re.findall(r"at_s: ([\d.]+)", told(words))]
    is_arena = "arena" in words  # ten images per second
    interrupt_after(max(events, default=0.0) + (0.5 if is_arena else SECONDS), monkeypatch)
    out = tmp_path / "run"

    code = cli.main([*shortened(words), "--out", str(out)])

    assert code in RAN, capsys.readouterr().err
    assert metrics_of(out)["ticks"] > 0


@pytest.mark.needs_ros
@pytest.mark.usefixtures("domain_id")
@pytest.mark.parametrize("words", over_ros(), ids=told)
def test_commands_that_need_ros_run_over_it(words: tuple[str, ...], tmp_path: Path) -> None:
    out = tmp_path / "run"
    kept = ["--live=0" if word == "--live" else word for word in words]  # any free port
    few = () if OF_FIXED_SIZE & set(words) else FEW

    ran = subprocess.run(
        [sys.executable, str(ROOT / LAUNCHER), *kept, *few, *OVER_ROS, "--out", str(out)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=ENDS_S,
        check=False,
        stdin=subprocess.DEVNULL,
    )

    assert ran.returncode in RAN, ran.stderr
    assert metrics_of(out)["engine"] == "ros"
    if "--record" in words:
        assert "none lost" in ran.stdout
        assert (out / "recording").is_dir()


@pytest.mark.parametrize("words", commands(BATCHES), ids=told)
def test_batches_run(words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = list(words)
    if "--scheduler" in kept:  # a cluster is the matter of test_monte_carlo_cluster.py
        del kept[kept.index("--scheduler") : kept.index("--scheduler") + 2]
    shape = ("--shape", "formation_1") if "--shape" in kept else ()

    code = batch_cli.main([*kept, *BATCH, *shape, "--out", str(tmp_path / "batch")])

    assert code == 0, capsys.readouterr().err
    assert (tmp_path / "batch" / "summary.md").stat().st_size > 0


@pytest.mark.parametrize("words", [each for each in commands(PREVIEW) if not is_of_the_example(each)], ids=told)
def test_commands_of_the_preview_run(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if "--help" in words:
        with pytest.raises(SystemExit, match="0"):
            shape_cli.main(list(words))
        return

    code = shape_cli.main(list(words))

    assert code == 0, capsys.readouterr()
    pictures = [words[place + 1] for place, word in enumerate(words) if word == "--out"]
    assert all((tmp_path / picture).stat().st_size > 0 for picture in pictures)


def test_code_settings_and_project_files_in_the_documents_are_sound() -> None:
    for path, text in blocks("python"):
        code = compile(text, str(path), "exec")
        if "import rclpy" not in text and "class " not in text:  # those need a swarm, or are an outline
            exec(code, {})
    for _, text in blocks("yaml"):
        load_config(ShapeSpec, yaml.safe_load(text)["shape"], "a document")
    projects = [tomllib.loads(path.read_text("utf-8"))["project"] for path in ROOT.glob("examples/*/pyproject.toml")]
    for _, text in blocks("toml"):
        assert tomllib.loads(text)["project"]["entry-points"] in [project["entry-points"] for project in projects]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the site, strictly."""
    folder = tmp_path_factory.mktemp("site")
    build = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert build.returncode == 0, build.stderr
    assert "WARNING" not in build.stderr
    return folder


def test_the_site_has_every_page_and_the_reference(site: Path) -> None:
    written = {path.relative_to(ROOT / "docs").with_suffix("") for path in (ROOT / "docs").rglob("*.md")}
    built = {path.relative_to(site).with_suffix("") for path in site.rglob("*.html")}

    assert written <= built
    assert {Path("reference/commands"), Path("reference/settings"), Path("reference/messages")} <= built


def test_the_reference_follows_from_the_code(site: Path) -> None:
    pages = {
        name: (site / "reference" / f"{name}.html").read_text("utf-8") for name in ("commands", "settings", "messages")
    }

    for script in (ROOT / "scripts").glob("*.py"):
        assert script.name in pages["commands"]
    assert "--list-scenarios" in pages["commands"]
    for kind in KINDS.values():
        for key in dotted_keys(kind.scenario):
            assert f"<code>{key}</code>" in pages["settings"], key
    for channel in every_channel():
        assert f"<code>{channel.template.replace('{node}', 'rNN')}</code>" in pages["messages"]
        assert channel.message in pages["messages"]
    for word in ("/world/power/rNN", "CostRow", "UNREACHABLE", "CoverageReport", "AssemblyInputs"):
        assert word in pages["messages"]


def test_the_site_needs_no_network_and_no_script_for_its_equations(site: Path) -> None:
    loaded = re.compile(r'<(?:script|link|img)[^>]*\s(?:src|href)="?(https?:[^"\s>]+)')
    for page in site.rglob("*.html"):
        assert loaded.findall(page.read_text("utf-8")) == [], page
        assert 'class="mermaid"' not in page.read_text("utf-8"), page  # nothing here would draw it
    for page in (site / "concepts").glob("*.html"):
        text = page.read_text("utf-8")
        assert "<math" in text, page
        assert "arithmatex" not in text, page
