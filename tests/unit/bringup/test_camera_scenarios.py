"""Scenarios with a camera: what fits together, what the film needs, and what the stages cost."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from tick_builders import PERIOD, make_plan, make_tick

from bringup.camera_checks import check_camera
from bringup.cli import BAD_INPUT, NOT_ACHIEVED, main
from bringup.compose import ScenarioActors
from bringup.filming import FILM, FilmOrder, filming
from bringup.inprocess import InProcessEngine
from bringup.layout import markers
from bringup.resolution import resolve, stages_of
from bringup.scenario import Scenario, SuccessSpec
from bringup.scenario_file import dump_scenario, load_scenario, parse_assignment
from bringup.stage_results import Ways, stage_results
from bringup.yaml_reader import parse_yaml
from swarm_msgs_py.config import load_config
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.metrics.trace import TraceRecorder


def arena(*assignments: str) -> Scenario:
    return resolve(*load_scenario("arena", tuple(map(parse_assignment, assignments))))


def test_every_robot_of_the_arena_wears_its_color() -> None:
    covers = markers(arena())

    assert [cover.color for cover in covers] == list(MarkerColor)
    assert [cover.radius for cover in covers] == [0.16, 0.11, 0.11, 0.08, 0.08]
    assert markers(resolve(*load_scenario("smoke-4"))) == ()


def test_headings_of_shapes_survive_writing_out() -> None:
    scenario = arena("shape.heading_deg=90", "stages=[{shape: {name: hw_5_line, heading_deg: -45}}]")
    again = load_config(Scenario, parse_yaml(dump_scenario(scenario)), "again")

    assert again.shape.heading_deg == 90.0
    assert [stage.heading for stage in stages_of(again)] == [pytest.approx(-math.pi / 4)]
    assert [stage.heading for stage in stages_of(arena())] == [None] * 4


@pytest.mark.parametrize(
    ("assignments", "words"),
    [
        (("sim.camera.is_on=false",), "from_camera needs sim.camera.is_on"),
        (("sim.camera.rate_hz=20",), "more than one image in a tick"),
        (("sim.camera.rate_hz=7",), "use 10 or 5 Hz"),
        (("sim.camera.rate_hz=1",), "notice_after_s .* takes that for a failure"),
        (("sim.camera.rate_hz=2", "mission.vision.notice_after_s=5"), "blind_after_s .* takes that for a failure"),
        (("sim.camera.view_m=1.5",), "floor mark at .* is out of view"),
        (("sim.camera.view_m=20",), "folds the corners"),
        (("sim.camera.elevation_m=1.0", "sim.camera.radial_distortion=-0.15"), "folds the corners"),
        (("sim.camera.radial_distortion=0.15",), "floor mark at .* is out of view"),
        (("sim.camera.width_px=480", "sim.camera.height_px=640"), "floor mark at .* is out of view"),
        (("sim.camera.width_px=160", "sim.camera.height_px=120"), "radius of 1.0 pixels"),
        (("sim.camera.roll_sigma_rad=0.2",), "floor mark at .* is out of view"),
        (("sim.camera.mount_sigma_m=2",), "mount_sigma_m"),
        (("sim.camera.aim_sigma_m=0.3",), "floor mark at .* is out of view"),
        (("sim.camera.noise_codes=200",), "noise_codes"),
        (("sim.camera.spots=[{color: red, center_m: [0, 0], radius_m: 20}]",), "spots.0. hides the floor mark"),
        (("mission.vision.dead_code=300",), "dead_code"),
        (("sim.drive.omni.rate_max_hz=0.5",), "rate_max_hz .* is less than the 439 Hz"),
        (("sim.drive.omni.rate_resolution_hz=5000",), "rate_resolution_hz .* is coarser than the 53 Hz"),
        (("sim.terrain.ground=rough",), "sim.terrain.ground to plane"),
        (("robots.types=[{type: 1, count: 1, coverage_radius_m: 0.1}]", "positions_m=null"), "no colors"),
        (("robots.types=[{type: 1, count: 2, colors: [red]}]", "positions_m=null"), "names 1 for 2 robots"),
        (("robots.types=[{type: 1, count: 2, colors: [red, red]}]", "positions_m=null"), "2 robots the color red"),
        (("robots.types=[{type: 1, count: 1, colors: [mauve]}]", "positions_m=null"), "mauve"),
    ],
)
def test_what_does_not_fit_together_is_refused_in_a_line(assignments: tuple[str, ...], words: str) -> None:
    with pytest.raises(ConfigError, match=words) as caught:
        arena(*assignments)
    assert "\n" not in str(caught.value)


def test_a_film_of_a_scenario_without_camera_is_bad_input(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["--scenario", "smoke-4", "--engine", "inprocess", "--show", "--out", str(tmp_path / "run")]

    assert main(words) == BAD_INPUT
    assert "--show: 'smoke-4' has no camera" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("size", [(640, 480), (320, 240), (1280, 960)])
def test_a_camera_mounted_by_any_seed_shows_what_it_must(size: tuple[int, int]) -> None:
    scenario = load_scenario("arena")[0]
    camera = replace(scenario.sim.camera, width_px=size[0], height_px=size[1])
    for seed in range(40):
        check_camera(replace(scenario, seed=seed, sim=replace(scenario.sim, camera=camera)))


def test_the_launcher_leaves_a_film_that_lasts_as_long_as_the_run(tmp_path: Path) -> None:
    out = tmp_path / "run"
    short = ("sim.physics.backend=massdamper", "duration_s=1.0", "stages=[]")
    words = [word for assignment in short for word in ("--set", assignment)]

    assert main(["--scenario", "arena", "--engine", "inprocess", "--show", "--out", str(out), *words]) == NOT_ACHIEVED
    film = cv2.VideoCapture(str(out / FILM))
    assert int(film.get(cv2.CAP_PROP_FRAME_COUNT)) == 10
    assert film.read()[1].shape == (480, 640, 3)


def test_a_film_shows_a_card_where_the_camera_gave_no_image(tmp_path: Path) -> None:
    scenario = arena("sim.physics.backend=massdamper", "sim.camera.off_from_s=0.3", "sim.camera.off_for_s=0.2")
    path = tmp_path / "camera.mp4"
    with InProcessEngine(ScenarioActors(scenario), film=FilmOrder(path, 10.0, 0.1)) as engine:
        ticks = engine.ticks()
        seen = [next(ticks).camera is not None for _ in range(8)]

    assert seen == [True] * 3 + [False] * 2 + [True] * 3
    film = cv2.VideoCapture(str(path))
    light = [float(film.read()[1].mean()) for _ in range(8)]
    assert [level > 0.6 * light[0] for level in light] == seen
    assert int(film.get(cv2.CAP_PROP_FRAME_COUNT)) == 8
    assert list(tmp_path.iterdir()) == [path]
    assert (film.get(cv2.CAP_PROP_FRAME_WIDTH), film.get(cv2.CAP_PROP_FRAME_HEIGHT)) == (640, 480)


def test_a_film_of_five_images_a_second_lasts_as_long_as_the_run(tmp_path: Path) -> None:
    scenario = arena("sim.physics.backend=massdamper", "sim.camera.rate_hz=5")
    path = tmp_path / "camera.mp4"
    with InProcessEngine(ScenarioActors(scenario), film=FilmOrder(path, 5.0, 0.1)) as engine:
        ticks = engine.ticks()
        assert [next(ticks).camera is not None for _ in range(6)] == [True, False] * 3

    film = cv2.VideoCapture(str(path))
    assert (int(film.get(cv2.CAP_PROP_FRAME_COUNT)), film.get(cv2.CAP_PROP_FPS)) == (3, pytest.approx(5.0))


def test_without_an_order_nothing_is_filmed(tmp_path: Path) -> None:
    scenario = arena("sim.physics.backend=massdamper")
    with filming(None) as film, InProcessEngine(ScenarioActors(scenario)) as engine:
        next(engine.ticks())
        film.take(ScenarioActors(scenario).mission(), None)  # type: ignore[arg-type]  # not looked at
    assert list(tmp_path.iterdir()) == []


STARTS, NORTH = np.array([[-2.0, 0.0], [2.0, 0.0]]), np.array([0.0, 1.0])


def costs(starts: FloatArray, plan: Plan) -> FloatArray:
    ways: FloatArray = np.linalg.norm(starts[:, None] - plan.goals[None], axis=2)
    return ways


def stage_of_choice(goals: tuple[int, int], ticks: int = 30) -> tuple[float | None, ...]:
    """Return bound, excess and arrival of robots that begin at their places, for goals 1 m north of both."""
    robots = (NodeId(0), NodeId(1))
    plan = make_plan((STARTS + NORTH).tolist())
    recorder = TraceRecorder(robots, PERIOD)
    for tick in range(ticks):
        places = (STARTS + min(1.0, 0.1 * tick) * NORTH).tolist()
        record = make_tick(tick, places, goals=goals)
        recorder.record(record.truth, record.reports)
    course = Course()
    course.put(0, plan)
    success = SuccessSpec(hold_s=2.0, goal_tolerance_m=0.05)
    (stage,) = stage_results(
        recorder.trace(), course, [0], PERIOD, success, Ways(np.array([1, 1], dtype=np.int64), costs)
    )
    return stage.bound_m, stage.excess_m, stage.arrival_s


def test_a_stage_knows_its_shortest_ways_and_when_all_had_arrived() -> None:
    bound, excess, arrival = stage_of_choice((0, 1))

    assert (bound, excess) == (pytest.approx(2.0), pytest.approx(0.0))
    assert arrival == pytest.approx(10 * PERIOD)


def test_robots_that_chose_each_others_goals_show() -> None:
    bound, excess, arrival = stage_of_choice((1, 0))

    assert bound == pytest.approx(2.0)
    assert excess == pytest.approx(2.0 * math.hypot(4.0, 1.0) - 2.0)
    assert arrival is None


def test_robots_without_goals_have_chosen_nothing() -> None:
    assert stage_of_choice((0, -1)) == (pytest.approx(2.0), None, None)
