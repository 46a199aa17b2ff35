"""The table of bad input: each case ends with code 2 and one line that names place, key and remedy; nothing happens."""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from run_folders import FAST

from bringup.cli import main
from bringup.inprocess import InProcessEngine
from bringup.scenario_file import SCENARIOS
from swarm_msgs_py.errors import ConfigError

Change = Callable[[dict[str, Any]], Any]


def changed(change: Change) -> str:
    """Return the smoke scenario's text after a change."""
    data = yaml.safe_load((SCENARIOS / "smoke-4.yaml").read_text())
    change(data)
    return yaml.safe_dump(data)


def types(*groups: dict[str, Any]) -> Change:
    return lambda data: data["robots"].update(types=list(groups))


def post(index: int) -> dict[str, Any]:
    """Return a round obstacle with as many corners as an obstacle may have, in its own place."""
    angles, x, y = np.linspace(0.0, 2.0 * np.pi, 128, endpoint=False), 15.0 + index % 10 * 5, 15.0 + index // 10 * 5
    corners = np.column_stack([x + np.cos(angles), y + np.sin(angles)])
    return {"name": f"post {index}", "vertices_m": corners.tolist()}


PEN = [
    {"name": "north", "vertices_m": [[-2.2, -1.6], [2.2, -1.6], [2.2, -1.4], [-2.2, -1.4]]},
    {"name": "south", "vertices_m": [[-2.2, -4.4], [2.2, -4.4], [2.2, -4.2], [-2.2, -4.2]]},
    {"name": "west", "vertices_m": [[-2.2, -4.4], [-2.0, -4.4], [-2.0, -1.4], [-2.2, -1.4]]},
    {"name": "east", "vertices_m": [[2.0, -4.4], [2.2, -4.4], [2.2, -1.4], [2.0, -1.4]]},
]
FILES = {
    "not a mapping": ("just text", r"bad\.yaml: expected keys and values"),
    "not YAML": ("name: [1, 2", r"bad\.yaml: not YAML \(line \d+, column \d+\)"),
    "unknown key": (changed(lambda d: d.update(speeed=1)), r"bad\.yaml: speeed: unknown key"),
    "unknown nested key, nearest named": (
        changed(lambda d: d["sim"]["terrain"].update(groud="plane")),
        r"bad\.yaml: sim\.terrain\.groud: unknown key; did you mean 'ground'\?",
    ),
    "missing key": (changed(lambda d: d.pop("shape")), r"bad\.yaml: shape: missing; add it"),
    "wrong type": (changed(lambda d: d.update(duration_s="long")), r"duration_s: expected a number, got 'long'"),
    "text for a list": (changed(types("all")), r"robots\.types\[0\]: expected keys and values"),  # type: ignore[arg-type]
    "negative radius": (
        changed(types({"type": 1, "count": 2, "coverage_radius_m": -0.1})),
        r"robots\.types\[0\]\.coverage_radius_m: must be > 0 m, got -0\.1",
    ),
    "NaN": (
        changed(lambda d: d["shape"].update(scale=float("nan"))),
        r"shape\.scale: must be > 0 and <= 10000, got nan",
    ),
    "unknown type without mechanics": (
        changed(types({"type": 7, "count": 2})),
        r"robots\.types\[0\]\.mass_kg: missing",
    ),
    "type named twice": (
        changed(types({"type": 1, "count": 2}, {"type": 1, "count": 2})),
        r"robots: types lists type 1 2 times; merge",
    ),
    "no robots": (changed(types({"type": 1, "count": 0})), r"robots: types has no robots; set the count"),
    "start points for other robots": (
        changed(lambda d: d["robots"]["start"].update(positions_m=[[0, 0]])),
        r"start\.positions_m has 1 points for 4 robots",
    ),
    "robots on top of each other": (
        changed(lambda d: d["robots"]["start"].update(positions_m=[[0, 0], [0.1, 0], [2, 0], [3, 0]])),
        r"bad\.yaml: robots: scene: r00 and r01 overlap at the start .*; move one",
    ),
    "no room to start": (
        changed(lambda d: d["robots"]["start"].update(half_side_m=0.2)),
        r"bad\.yaml: robots: no room for r0\d .*; enlarge start\.half_side_m",
    ),
    "shape of nothing": (changed(lambda d: d.update(shape={})), r"bad\.yaml: shape: no shape; give one of name, file"),
    "shape crossing itself": (
        changed(lambda d: d.update(shape={"points": [[0, 0], [2, 2], [2, 0], [0, 2]]})),
        r"bad\.yaml: shape: .*crosses or touches itself at \(1\.00, 1\.00\)",
    ),
    "shape with NaN": (
        changed(lambda d: d.update(shape={"points": [[0, 0], [2, float("nan")], [2, 2]]})),
        r"bad\.yaml: shape\.points\[1\]\[1\]: must be a finite number",
    ),
    "shape of two points": (
        changed(lambda d: d.update(shape={"points": [[0, 0], [2, 2]]})),
        r"bad\.yaml: shape: .*only 2 different vertices; a contour needs at least 3",
    ),
    "shape too small, needed size told": (
        changed(lambda d: d["shape"].update(scale=0.6)),
        r"bad\.yaml: shape: a shape of .* needs .* m2; scale it by at least",
    ),
    "shape out of bounds": (
        changed(lambda d: d["shape"].update(translation_m=[4.5, 0])),
        r"bad\.yaml: shape: 'hw_2_square': vertex .* outside the arena .*; move or shrink",
    ),
    "stage of nothing": (
        changed(lambda d: d.update(stages=[{"over_s": 5.0}])),
        r"bad\.yaml: stages\[0\]: a stage without a shape; give shape, split, join",
    ),
    "motion of a shape that cannot move": (
        changed(
            lambda d: d.update(stages=[{"scale": 1.1, "over_s": 5}], mission={"partition": {"method": "fractals"}})
        ),
        r"bad\.yaml: stages\[0\]: partition method fractals is not applicable to moving shapes; use bubble-packing",
    ),
    "motion out of the arena": (
        changed(lambda d: d.update(stages=[{"scale": 1.1}, {"translate_m": [4.5, 0.0], "over_s": 9.0}])),
        r"bad\.yaml: stages\[1\]: 'shape': vertex .* outside the arena .*; move or shrink",
    ),
    "obstacle over the shape": (
        changed(lambda d: d["shape"].update(translation_m=[2.5, 2.5])),
        r"bad\.yaml: shape: lies over obstacle 'post' near \(2\.\d, 2\.\d\); move one of them",
    ),
    "missing shape file": (
        changed(lambda d: d.update(shape={"file": "gone.json"})),
        r"bad\.yaml: shape: gone\.json: no such file",
    ),
    "unknown map": (changed(lambda d: d.update(map={"name": "arena_mian"})), r"did you mean 'arena_main'\?"),
    "bounds in disorder": (
        changed(lambda d: d["map"].update(bounds_m=[5, -5, -5, 5])),
        r"bad\.yaml: map: bounds_m must be \[x_min",
    ),
    "obstacle crossing itself": (
        changed(lambda d: d["map"].update(obstacles=[{"name": "bow", "vertices_m": [[3, 3], [4, 4], [4, 3], [3, 4]]}])),
        r"bad\.yaml: map: obstacle 'bow': .*crosses or touches itself",
    ),
    "robots walled off from the shape": (
        changed(
            lambda d: (
                d["map"].update(obstacles=PEN),
                d["robots"]["start"].update(positions_m=[[0, -3], [1, -3], [-1, -3], [3, 3]]),
            )
        ),
        r"bad\.yaml: robots: no path leads from r00, r01, r02 to the shape; move",
    ),
    "nested beyond reason": ("[" * 5000, r"bad\.yaml: not YAML that can be read: nested too deeply; correct"),
    "key told twice": ("name: a\nseed: 1\nseed: 2\n", r"bad\.yaml: key 'seed' is told in line 2 and again in line 3"),
    "halves of the arena without a gap": (
        changed(
            lambda d: (
                d["map"].update(
                    obstacles=[{"name": "wall", "vertices_m": [[2.4, -4.9], [2.6, -4.9], [2.6, 4.9], [2.4, 4.9]]}]
                )
                or d["robots"]["start"].update(positions_m=[[0, -3], [1, -3], [-1, -3], [4, 3]])
            )
        ),
        r"bad\.yaml: robots: no path leads from r03 to the shape; move",
    ),
    "start against the edge": (
        changed(lambda d: d["robots"]["start"].update(positions_m=[[0, -3], [1, -3], [-1, -3], [4.9, 3]])),
        r"bad\.yaml: robots: r03 starts at \(4\.9, 3\), outside the arena or against its edge; move it",
    ),
    "mission computer in the margin of an obstacle": (
        changed(lambda d: d.update(mission={"position_m": [2.3, 2.7]})),
        r"bad\.yaml: mission\.position_m: r00 has no path to the rally point \(2\.3, 2\.7\): .* into the open",
    ),
    "rally point outside the arena": (
        changed(lambda d: d.update(agent={"decision": {"rally_point_m": [9, 0]}})),
        r"bad\.yaml: agent\.decision\.rally_point_m: r00 has no path to the rally point",
    ),
    "goals in the planner's margin": (
        changed(
            lambda d: (
                d["map"].update(obstacles=[{"name": "w", "vertices_m": [[-4, 1.1], [4, 1.1], [4, 1.3], [-4, 1.3]]}]),
                d.update(agent={"planning": {"clearance_margin_m": 0.9}}),
                d["robots"]["start"].update(positions_m=[[0, -3], [1, -3], [-1, -3], [2, -3]]),
            )
        ),
        r"bad\.yaml: robots: goal \d at .* cannot be reached by robots of type 1: .*planning\.clearance_margin_m",
    ),
    "goals nearer than avoidance allows": (
        changed(lambda d: d.update(mission={"partition": {"gaps": {"robot_m": 0.08}}})),
        r"bad\.yaml: mission\.partition\.gaps: .*robot_m \(0\.08 m\) .* agent\.control\.avoidance\.margin_m",
    ),
    "arena wider than path lengths can say": (
        changed(lambda d: d["map"].update(bounds_m=[-300, -300, 300, 300])),
        r"bad\.yaml: map: the arena measures 849 m across, robots can tell path lengths up to 655 m; make it smaller",
    ),
    "plan larger than a radio frame": (
        changed(lambda d: d["map"].update(bounds_m=[-5, -5, 90, 180], obstacles=[post(index) for index in range(140)])),
        r"bad\.yaml: shape: the plan cannot be radioed: Plan of \d+ bytes; .* simplify the contour or the obstacles",
    ),
    "death of a robot that is not there": (
        changed(lambda d: d.update(events=[{"at_s": 1, "kill": [3]}, {"at_s": 2, "kill": [4]}])),
        r"bad\.yaml: events: events\[1\]\.kill: there is no r04; the robots are r00 to r03",
    ),
    "death after the end": (
        changed(lambda d: d.update(events=[{"at_s": 60, "kill": [3]}])),
        r"bad\.yaml: events: events\[0\]\.at_s: 60 s is not before the time limit of 60 s; lower it",
    ),
    "two deaths of one robot": (
        changed(lambda d: d.update(events=[{"at_s": 1, "kill": [3]}, {"at_s": 2, "kill": [3]}])),
        r"bad\.yaml: events: events\[1\]\.kill: r03 is killed twice; remove it",
    ),
    "event without a time": (
        changed(lambda d: d.update(events=[{"kill": [3]}])),
        r"bad\.yaml: events\[0\]\.at_s: missing; add it",
    ),
    "event without an effect": (
        changed(lambda d: d.update(events=[{"at_s": 1}])),
        r"bad\.yaml: events\[0\]: an event without effect; give kill: \[robots\], add: \[robots\] or stop: mission",
    ),
    "stop of what cannot be stopped": (
        changed(lambda d: d.update(events=[{"at_s": 1, "stop": "mission"}])),
        r"bad\.yaml: events\[0\]\.stop: .*mission_computer",
    ),
    "two stops": (
        changed(lambda d: d.update(events=[{"at_s": n, "stop": "mission_computer"} for n in (1, 2)])),
        r"bad\.yaml: events: events\[1\]\.stop: the mission computer is stopped twice; remove it here or there",
    ),
    "settings that contradict each other": (
        changed(lambda d: d.update(agent={"control": {"park_m": 0.5, "unpark_m": 0.1}})),
        r"bad\.yaml: agent\.control: unpark_m must be > park_m",
    ),
}

OPTIONS = {
    "unknown option": (["--sede", "3"], r"--sede: unknown option; did you mean '--seed'\?"),
    "stray word": (["demo"], r"demo: unknown option"),
    "option without value": (["--agents"], r"--agents: expected one argument"),
    "no agents": (["--agents", "0"], r"--agents: expected a whole number from 1 to 1000, got '0'"),
    "agents in words": (["--agents", "many"], r"--agents: expected a whole number"),
    "more agents than the shape holds": (["--agents", "900"], r"too small for 900 robots: needs"),
    "negative seed": (["--seed", "-1"], r"--seed: expected a whole number"),
    "unknown engine": (["--engine", "rso"], r"--engine: there is no 'rso'; did you mean 'ros'\?"),
    "unknown physics": (["--physics", "bulet"], r"--physics: there is no 'bulet'; did you mean 'bullet'\?"),
    "unknown method": (["--method", "bubble"], r"--method: there is no 'bubble'; did you mean 'bubble-packing'\?"),
    "unknown force law": (["--method", "force-literal"], r"--method: .*did you mean 'forces-literal'\?"),
    "unknown task": (["--set", "mission.task=force"], r"--set mission\.task: .*did you mean 'forces'\?"),
    "too narrow for the method": (
        ["--method", "voronoi", "--set", "shape.scale=0.5"], r"too narrow for robots of type 1 .*scale it by at least",
    ),
    "unknown scenario": (["--scenario", "formation-5"], r"--scenario formation-5: .*did you mean 'formation-50'\?"),
    "missing scenario file": (["--scenario", "gone.yaml"], r"gone\.yaml: no such file"),
    "folder as a scenario": (["--scenario", "./"], r"cannot be read \(Is a directory\)"),
    "unknown shape": (["--shape", "formation_9"], r"--shape formation_9: .*did you mean 'formation_4'\?"),
    "missing shape file on the command line": (["--shape", "gone.json"], r"--shape gone\.json: .*no such file"),
    "unknown map on the command line": (["--map", "arena"], r"--map arena: .*did you mean|choose from"),
    "assignment without value": (["--set", "loss"], r"--set loss: expected key=value"),
    "assignment to nothing": (["--set", "radio.los=1"], r"--set radio\.los: unknown key 'radio\.los'; did you mean"),
    "ambiguous assignment": (["--set", "sigma_m=1"], r"--set sigma_m: 'sigma_m' could be .* or .*; write one"),
    "assignment out of range": (["--set", "radio.loss=2"], r"--set radio\.loss: sim\.radio\.loss: must be >= 0"),
    "assignment of broken YAML": (["--set", "name=[1"], r"--set name: the value is not YAML"),
    "processes without ROS": (["--agents-per-process", "2"], r"--agents-per-process: only the ros engine"),
    "recording": (["--record", *FAST], r"--record: only the ros engine has topics to record; leave it out or use"),
    "out folder in use": (["--out", "used"], r"--out used: is not empty; give a new folder"),
    "out folder below a file": (["--out", "used/file/below"], r"--out used/file/below: cannot be written"),
    "out folder where nobody may write": (["--out", "/proc/nobody/here"], r"--out /proc/nobody/here: cannot be"),
}  # fmt: skip


@pytest.fixture(autouse=True)
def nothing_may_start(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run in a folder of our own, in which one folder is in use; fail where an engine starts."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "file").write_text("precious")
    monkeypatch.setattr(InProcessEngine, "__enter__", lambda _: pytest.fail("an engine was started"))


def assert_refused(argv: list[str], pattern: str, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(Path().rglob("*"))

    code = main(argv)

    captured = capsys.readouterr()
    assert code == 2
    assert captured.out == ""
    assert re.fullmatch(r"error: [^\n]+\n", captured.err)
    assert re.search(pattern, captured.err)
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize("case", FILES)
def test_a_bad_file_is_refused(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, pattern = FILES[case]
    (tmp_path / "bad.yaml").write_text(text)

    assert_refused([*FAST, "--scenario", "bad.yaml"], pattern, capsys)


@pytest.mark.parametrize("case", OPTIONS)
def test_a_bad_option_is_refused(case: str, capsys: pytest.CaptureFixture[str]) -> None:
    options, pattern = OPTIONS[case]

    assert_refused([*FAST, "--scenario", "smoke-4", *options], pattern, capsys)


def test_an_engine_that_refuses_to_start_leaves_no_folder(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: InProcessEngine) -> InProcessEngine:
        raise ConfigError("ROS_DOMAIN_ID=7: is in use by another swarm; choose another number")

    monkeypatch.setattr(InProcessEngine, "__enter__", refuse)
    before = sorted(Path().rglob("*"))

    assert main([*FAST, "--out", "new/run"]) == 2
    assert capsys.readouterr().err == "error: ROS_DOMAIN_ID=7: is in use by another swarm; choose another number\n"
    assert sorted(Path().rglob("*")) == before


@pytest.mark.needs_ros
@pytest.mark.parametrize(
    ("domain", "pattern"),
    [(None, r"ROS_DOMAIN_ID: domain \d+ is in use by .*; set ROS_DOMAIN_ID to another"), ("x", "whole number .* 'x'")],
    ids=["taken", "not a number"],
)
def test_a_ros_domain_that_cannot_be_had_is_refused(
    domain: str | None,
    pattern: str,
    domain_id: int,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from bringup.domain_guard import DomainGuard  # noqa: PLC0415 - imports ROS names

    if domain is not None:
        monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    guard = DomainGuard(domain_id)
    guard.acquire()
    before = sorted(Path().rglob("*"))
    try:
        code = main(["--physics", "massdamper", "--scenario", "smoke-4"])
    finally:
        guard.release()

    assert code == 2
    assert re.fullmatch(f"error: [^\n]*{pattern}[^\n]*\n", capsys.readouterr().err)
    assert sorted(Path().rglob("*")) == before


@pytest.mark.parametrize(
    ("library", "options", "pattern"),
    [
        (
            "rclpy",
            ["--engine", "ros", "--physics", "massdamper"],
            "rclpy is not installed; .* or use --engine inprocess",
        ),
        ("pybullet", ["--engine", "inprocess"], "pybullet is not installed; .* or use --physics massdamper"),
    ],
)
def test_a_missing_library_is_told_before_the_start(
    library: str,
    options: list[str],
    pattern: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == library else find(name))

    assert_refused(options, pattern, capsys)
