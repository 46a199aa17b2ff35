from __future__ import annotations

import io
from enum import IntEnum
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from rich.text import Text

from bringup import formation_scenes
from bringup.assembly.scenes import COLORS as BOATS
from bringup.compose import ScenarioActors
from bringup.coverage.scenes import COLORS as COVERAGE
from bringup.dashboard import Dashboard
from bringup.engine import TickRecord
from bringup.formation_scenes import FormationScenes
from bringup.inprocess import InProcessEngine
from bringup.progress import Progress
from bringup.resolution import resolve
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario, parse_assignment
from bringup.scene import ALARM, GONE, STYLES, UNDER_WAY, WELL, Rgb, RobotView, Scene
from swarm_msgs_py.assembly.boat_io import BoatMode
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.types import NodeId

TICKS = 12
KILLED = 2


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    settings = ("backend=massdamper", f"events=[{{at_s: 5.0, kill: [{KILLED}]}}]")
    return resolve(*load_scenario("smoke-4", tuple(map(parse_assignment, settings))))


@pytest.fixture(scope="module")
def records(scenario: Scenario) -> list[TickRecord]:
    with InProcessEngine(ScenarioActors(scenario)) as engine:
        return [record for record, _ in zip(engine.ticks(), range(TICKS), strict=False)]


@pytest.fixture
def scene(scenario: Scenario, records: list[TickRecord]) -> Scene:
    scenes = FormationScenes(scenario)
    return [scenes.take(record) for record in records][-1]


@pytest.fixture
def board(scenario: Scenario, records: list[TickRecord]) -> Dashboard:
    board = Dashboard(FormationScenes(scenario))
    for record in records:
        board.take(record)
    return board


def shown(board: Dashboard, height: int) -> list[str]:
    """Return the lines of the dashboard."""
    console = Console(file=io.StringIO(), width=140, record=True)
    console.print(board.render(Text("12.0 s"), height))
    return console.export_text().splitlines()


def fact(view: RobotView, column: str) -> str | float | int | None:
    """Return what a robot's view says in a column."""
    return view.facts[FormationScenes.columns.index(column)]


def test_every_robot_has_a_line_with_true_distances_and_errors(
    board: Dashboard, scene: Scene, records: list[TickRecord]
) -> None:
    lines, last = shown(board, 40), records[-1]

    assert lines[0].strip() == "12.0 s"
    assert lines[1].split()[:4] == ["robot", "mode", "position", "goal"]
    assert [line.split()[0] for line in lines[2:]] == ["r00", "r01", "r02", "r03"]
    for view in scene.robots:
        if view.robot == KILLED:
            continue
        report, place = last.reports[view.robot], last.truth.positions[view.robot]
        assert fact(view, "error [m]") == pytest.approx(np.linalg.norm(report.position - place))
        distance = fact(view, "to goal [m]")
        assert distance == pytest.approx(np.linalg.norm(scene.places[report.goal] - place))
        assert lines[2 + view.robot].split()[1] == report.mode.name.lower()
        assert f"{distance:.2f}" in lines[2 + view.robot]
    assert {last.reports[robot].mode for robot in last.reports} <= set(Mode)


def test_a_dead_robot_is_off(board: Dashboard, scene: Scene) -> None:
    assert shown(board, 40)[2 + KILLED].split() == ["r02", "off"]
    assert scene.robots[KILLED].color == GONE
    assert scene.robots[KILLED].attention[0] == ALARM


def test_links_are_told_once_and_end_at_robots(scene: Scene) -> None:
    assert scene.links
    assert all(0 <= one < other < len(scene.robots) for one, other in scene.links)
    assert len(set(scene.links)) == len(scene.links)


def test_on_a_small_terminal_robots_that_need_attention_stay(board: Dashboard) -> None:
    lines = shown(board, 8)

    assert "r02" in {line.split()[0] for line in lines[2:4]}
    assert lines[-1].strip().startswith("and 2 more")


def test_the_dashboard_shows_on_terminals_and_plain_lines_elsewhere(
    scenario: Scenario, records: list[TickRecord], tmp_path: Path
) -> None:
    for is_terminal in (True, False):
        with (tmp_path / "out").open("w") as file:
            console = Console(file=file, width=120, height=30, force_terminal=is_terminal)
            with Progress(console, Dashboard(FormationScenes(scenario))) as progress:
                for record in records:
                    progress.show(record, record.truth.time + 0.5, "4 robots")
        assert ("to goal [m]" in (tmp_path / "out").read_text()) == is_terminal


def test_numbers_have_two_digits_and_what_is_unknown_a_dash() -> None:
    class OneRobot:
        columns = ("to place [m]", "links", "word")
        radii = np.ones(1)
        walls = ()

        def take(self, record: TickRecord) -> Scene:  # noqa: ARG002
            view = RobotView(NodeId(0), "busy", GONE, (WELL, 0.0), (1.234, None, "yes"))
            return Scene((view,), np.zeros((1, 2)))

    board = Dashboard(OneRobot())
    board.take(None)

    assert shown(board, 20)[2].split() == ["r00", "busy", "1.23", "-", "yes"]


@pytest.mark.parametrize(
    ("colors", "modes"), [(formation_scenes.COLORS, Mode), (COVERAGE, CoverageMode), (BOATS, BoatMode)], ids=str
)
def test_every_mode_of_every_family_has_a_color(colors: dict[IntEnum, Rgb], modes: type[IntEnum]) -> None:
    assert set(colors) == set(modes)
    assert set(colors.values()) <= set(STYLES)


def test_hidden_robots_are_called_well_only_if_they_are() -> None:
    class Busy:
        columns = ("links",)
        radii = np.ones(3)
        walls = ()

        def take(self, record: TickRecord) -> Scene:  # noqa: ARG002
            views = tuple(RobotView(NodeId(n), "busy", GONE, (UNDER_WAY, 0.0), (n,)) for n in range(3))
            return Scene(views, np.zeros((3, 2)))

    board = Dashboard(Busy())
    board.take(None)

    assert shown(board, 8)[-1].strip() == "and 1 more"
