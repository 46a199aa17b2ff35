"""The documentation site builds without a warning, and what its pages tell people to type does what it says.

Commands of the launcher are run as they stand, but for what would take minutes: without ROS, with the light physics,
with few robots and for some seconds, and those with several shapes up to the first tick. Batches and studies are run by
tests of their own.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from documented_commands import LAUNCHER, commands, told
from run_folders import metrics_of
from source_tree import ROOT

from bringup import cli
from previews import shape_cli

FORMATION = ("--engine", "inprocess", "--physics", "massdamper", "--set", "success.hold_s=0")
SHORTENED = {
    "arena": (*FORMATION, "--set", "stages=[]"),
    "coverage": ("--engine", "inprocess", "--set", "events=[]"),
    "assembly": ("--engine", "inprocess", "--physics", "massdamper"),
}
"""By the first word of a scenario's name; the others are formations."""
FEW = {"formation": ("--agents", "8"), "split": ("--agents", "8"), "morph": ("--agents", "8")}
PREVIEW = "scripts/shape.py"
ROS_ONLY = ("--real-time", "--dashboard", "--record", "--live", "--agents-per-process")
RAN = {0, 1}  # achieved or not: so soon mostly not


@pytest.mark.parametrize("words", commands(LAUNCHER), ids=told)
def test_commands_of_the_launcher_run(
    words: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if "--help" in words:
        with pytest.raises(SystemExit, match="0"):
            cli.main(list(words))
        return
    kept = [word for word in words if word not in ROS_ONLY]
    kind = kept[kept.index("--scenario") + 1].partition("-")[0] if "--scenario" in kept else ""
    fewer = FEW.get(kind, ())
    if any(word in told(words) for word in ("--explain", "--list-scenarios", "stages", "sequence", "morph")):
        assert cli.main([*kept, *fewer, "--explain"]) == 0, capsys.readouterr().err
        return
    out = tmp_path / "run"
    times = [float(text) for text in re.findall(r"at_s: ([\d.]+)", told(words))]
    until_s = 2.0 + max(times, default=0.0)

    shortened = SHORTENED.get(kind, FORMATION)
    code = cli.main([*kept, *shortened, *fewer, "--set", f"duration_s={until_s:g}", "--out", str(out)])

    assert code in RAN, capsys.readouterr().err
    assert metrics_of(out)["ticks"] > 0


@pytest.mark.parametrize("words", commands(PREVIEW), ids=told)
def test_commands_of_the_preview_run(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    code = shape_cli.main(list(words))

    assert code == 0, capsys.readouterr()
    pictures = [words[place + 1] for place, word in enumerate(words) if word == "--out"]
    assert all((tmp_path / picture).stat().st_size > 0 for picture in pictures)


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
    for word in ("/world/power/rNN", "geometry_msgs/msg/PolygonStamped", "CostRow", "UNREACHABLE"):
        assert word in pages["messages"]


def test_the_site_needs_no_network_and_no_script_for_its_equations(site: Path) -> None:
    loaded = re.compile(r'<(?:script|link|img)[^>]*\s(?:src|href)="?(https?:[^"\s>]+)')
    for page in site.rglob("*.html"):
        assert loaded.findall(page.read_text("utf-8")) == [], page
    for page in (site / "concepts").glob("*.html"):
        text = page.read_text("utf-8")
        assert "<math" in text, page
        assert "arithmatex" not in text, page
