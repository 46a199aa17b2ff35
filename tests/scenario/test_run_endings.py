"""Ends of a run that no scenario brings about: interruptions, dying robots, engines that give up."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from run_folders import FILES, metrics_of

import bringup.run
import reports.figures
from bringup.compose import ScenarioActors
from bringup.engine import TickRecord
from bringup.family import Metrics
from bringup.formation import FormationAccount
from bringup.inprocess import InProcessEngine
from bringup.interruption import Interruption
from bringup.progress import Progress
from bringup.resolution import resolve
from bringup.run import Run, execute, write_results
from bringup.run_folder import RunFolder
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, parse_assignment
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.types import NodeId
from swarm_sim.simulation import Simulation

EVENT_TICK = 8


@pytest.fixture(scope="module")
def smoke() -> Scenario:
    return resolve(*load_scenario("smoke-4", (parse_assignment("backend=massdamper"),)))


class EventfulEngine(InProcessEngine):
    """The real engine, in which something happens at one tick, or at the start."""

    def __init__(self, scenario: Scenario, event: Callable[[], None], *, at_start: bool = False) -> None:
        super().__init__(ScenarioActors(scenario))
        self._event = event
        self._at_start = at_start
        self.is_stopped = False

    def __enter__(self) -> EventfulEngine:
        if self._at_start:
            self._event()
        super().__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        self.is_stopped = True
        super().__exit__(*error)

    def ticks(self) -> Iterator[TickRecord]:
        for record in super().ticks():
            if record.tick == EVENT_TICK:
                self._event()
            yield record


def interrupt() -> None:
    os.kill(os.getpid(), signal.SIGINT)


def give_up() -> None:
    raise SwarmError("the world node died (exit code 9)")


def run(scenario: Scenario, engine: EventfulEngine, folder: Path, interruption: Interruption) -> Metrics:
    with Progress(Console(stderr=True)) as progress:
        kept = RunFolder(folder)
        whole = Run(scenario, "inprocess", FormationAccount(scenario), kept)
        ended = execute(whole, engine, interruption, progress)
    return write_results(whole, ended, interruption, progress.say)


def test_an_interruption_stops_the_engine_and_keeps_the_metrics_so_far(smoke: Scenario, tmp_path: Path) -> None:
    engine = EventfulEngine(smoke, interrupt)
    with Interruption() as interruption:
        run(smoke, engine, tmp_path, interruption)

    metrics = metrics_of(tmp_path)
    assert engine.is_stopped
    assert metrics["ticks"] == EVENT_TICK
    assert metrics["reason"].startswith("interrupted by the operator at 4.0 s")
    assert metrics["total_displacement_m"] > 0.0
    assert sorted(path.name for path in tmp_path.iterdir()) == [name for name in FILES if name != "figure.png"]


def test_an_interruption_during_the_start_leaves_a_readable_folder(smoke: Scenario, tmp_path: Path) -> None:
    engine = EventfulEngine(smoke, interrupt, at_start=True)
    with Interruption() as interruption:
        run(smoke, engine, tmp_path, interruption)

    metrics = metrics_of(tmp_path)
    assert engine.is_stopped
    assert metrics["ticks"] == 0
    assert metrics["displacement_lower_bound_m"] is None


def test_an_interruption_while_drawing_keeps_everything_but_the_picture(
    smoke: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(reports.figures, "make_figure", lambda *_: interrupt())
    with Interruption() as interruption:
        metrics = run(smoke, EventfulEngine(smoke, lambda: None), tmp_path, interruption)
        was_requested = interruption.requested

    assert metrics.achieved
    assert was_requested
    assert sorted(path.name for path in tmp_path.iterdir()) == [name for name in FILES if name != "figure.png"]


def test_pictures_that_cannot_be_made_cost_neither_numbers_nor_verdict(
    smoke: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(bringup.run, "report_page", lambda _: 1 / 0)
    monkeypatch.setattr(reports.figures, "make_figure", lambda *_: int("x"))
    with Interruption() as interruption:
        metrics = run(smoke, EventfulEngine(smoke, lambda: None), tmp_path, interruption)

    assert metrics.achieved
    assert metrics_of(tmp_path)["achieved"] is True
    assert sorted(path.name for path in tmp_path.iterdir()) == ["metrics.json", "scenario.yaml", "trajectories.npz"]
    lines = capsys.readouterr().err.splitlines()
    for name, reason in (("report.html", "ZeroDivisionError: division by zero"), ("figure.png", "ValueError")):
        assert [line for line in lines if f"{name}: could not be made ({reason}" in line]


def test_an_engine_that_gives_up_ends_the_run_with_its_reason(smoke: Scenario, tmp_path: Path) -> None:
    engine = EventfulEngine(smoke, give_up)
    with Interruption() as interruption:
        metrics = run(smoke, engine, tmp_path, interruption)

    assert engine.is_stopped
    assert (metrics.achieved, metrics.reason) == (False, "the world node died (exit code 9)")
    assert metrics.values["ticks"] == EVENT_TICK


def test_an_engine_that_refuses_to_start_is_stopped_and_heard(smoke: Scenario, tmp_path: Path) -> None:
    engine = EventfulEngine(smoke, give_up, at_start=True)

    with Interruption() as interruption, pytest.raises(SwarmError, match="world node died"):
        run(smoke, engine, tmp_path, interruption)

    assert engine.is_stopped


def test_a_robot_that_dies_is_counted_and_the_rest_go_on(
    smoke: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    worlds: list[Simulation] = []
    make = ScenarioActors.simulation
    monkeypatch.setattr(ScenarioActors, "simulation", lambda actors: worlds.append(make(actors)) or worlds[0])
    engine = EventfulEngine(smoke, lambda: worlds[0].kill(NodeId(2)))
    with Interruption() as interruption:
        metrics = run(smoke, engine, tmp_path, interruption)

    assert metrics.achieved, metrics.reason
    values = metrics.values
    assert values["displacement_lower_bound_m"] is not None
    assert values["displacement_lower_bound_m"] < values["total_displacement_m"]
    assert (values["lost_robots"], values["goals_reached"]) == (1, 3)
    assert "1 lost" in metrics.reason


def test_what_is_on_disk_while_a_run_goes_on_is_readable(smoke: Scenario, tmp_path: Path) -> None:
    seen: dict[str, object] = {}

    def look() -> None:
        seen.update(metrics_of(tmp_path))
        seen["files"] = sorted(path.name for path in tmp_path.iterdir())
        seen["again"] = resolve(*load_scenario(str(tmp_path / "scenario.yaml")))
        with np.load(tmp_path / "trajectories.npz") as arrays:
            seen["ticks recorded"] = len(arrays["tick_time"])

    with Interruption() as interruption:
        metrics = run(smoke, EventfulEngine(smoke, look), tmp_path, interruption)

    assert seen["files"] == ["metrics.json", "scenario.yaml", "trajectories.npz"]
    assert seen["again"] == smoke
    assert str(seen["reason"]).startswith("still running at 0.5 s")
    assert seen["ticks recorded"] == seen["ticks"] == 1
    assert seen["achieved"] is False
    assert metrics_of(tmp_path)["reason"] == metrics.reason


def test_saves_are_due_now_and_then_only(smoke: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    write = RunFolder.write
    monkeypatch.setattr(
        RunFolder, "write", lambda folder, name, data: written.append(name) or write(folder, name, data)
    )
    with Interruption() as interruption:
        run(smoke, EventfulEngine(smoke, lambda: None), tmp_path, interruption)

    assert written.count("metrics.json") == 2  # after the first tick and at the end of this short run


def test_a_disk_that_takes_nothing_for_a_while_does_not_end_the_run(
    smoke: Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, attempts = RunFolder.write, iter(range(100))

    def fail_at_first(folder: RunFolder, name: str, data: bytes) -> Path:
        if next(attempts) < 2:
            raise OSError(28, "No space left on device")
        return write(folder, name, data)

    monkeypatch.setattr(RunFolder, "write", fail_at_first)
    with Interruption() as interruption:
        metrics = run(smoke, EventfulEngine(smoke, lambda: None), tmp_path, interruption)

    assert metrics.achieved
    assert metrics_of(tmp_path)["achieved"] is True
