from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from bringup.family import Family
from bringup.resolution import resolve
from bringup.scenario import Scenario, rescaled_counts
from bringup.scenario_file import (
    ROBOT_COUNT,
    SCENARIOS,
    Origin,
    Override,
    dump_scenario,
    load_scenario,
    map_override,
    method_overrides,
    parse_assignment,
    scenario_names,
    shape_override,
)
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import MISSION


def loaded(source: str, *overrides: Override) -> Scenario:
    return load_scenario(source, overrides)[0]


def written(folder: Path, **changes: Any) -> str:
    """Return a file with the smoke scenario, changed at its top level."""
    data = yaml.safe_load((SCENARIOS / "smoke-4.yaml").read_text())
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump({**data, **changes}))
    return str(path)


@pytest.mark.parametrize("name", scenario_names(Family.FORMATION))
def test_every_ready_made_scenario_passes_every_check(name: str) -> None:
    scenario, origin = load_scenario(name)

    assert resolve(scenario, origin).name == name


def test_types_of_the_thesis_need_only_a_count() -> None:
    assert tuple(group.robot_type() for group in loaded("demo").robots.types) == THESIS_TYPES


def test_what_the_file_says_of_a_type_wins_over_the_thesis(tmp_path: Path) -> None:
    source = written(
        tmp_path, robots={"types": [{"type": 1, "count": 4, "mass_kg": 9.0}], "start": {"half_side_m": 3.5}}
    )

    (group,) = loaded(source).robots.types

    assert (group.mass_kg, group.coverage_radius_m) == (9.0, THESIS_TYPES[0].coverage_radius_m)


def test_a_resolved_scenario_survives_the_file_it_is_written_to(tmp_path: Path) -> None:
    resolved = resolve(*load_scenario("formation-50"))
    path = tmp_path / "scenario.yaml"
    path.write_text(dump_scenario(resolved))

    again, origin = load_scenario(str(path))

    assert again == resolved
    assert resolve(again, origin) == resolved


def test_a_resolved_scenario_depends_on_no_other_file(tmp_path: Path) -> None:
    (tmp_path / "tri.json").write_text("[[-2, -2], [2, -2], [0, 2]]")
    resolved = resolve(*load_scenario(written(tmp_path, shape={"file": "tri.json"})))

    assert resolved.shape.file is None
    assert resolved.shape.name == "tri"
    assert resolved.shape.points == ((-2.0, -2.0), (2.0, -2.0), (0.0, 2.0))


def test_scale_rotation_and_translation_are_applied_once(tmp_path: Path) -> None:
    shape = {"points": [[0, 0], [2, 0], [2, 2], [0, 2]], "scale": 2.0, "rotation_deg": 90.0, "translation_m": [-1, -1]}
    once = resolve(*load_scenario(written(tmp_path, shape=shape)))
    twice = resolve(once, Origin("again"))

    assert once.shape.points is not None
    corners = {(round(x, 9), round(y, 9)) for x, y in once.shape.points}
    assert corners == {(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)}
    assert twice == once


def test_a_later_override_wins() -> None:
    scenario = loaded("demo", parse_assignment("loss=0.1"), parse_assignment("sim.radio.loss=0.2"))

    assert scenario.sim.radio.loss == 0.2


def test_values_of_assignments_are_yaml() -> None:
    scenario = loaded("demo", parse_assignment("shape.translation_m=[1, 2.5]"), parse_assignment("description=a"))

    assert scenario.shape.translation_m == (1.0, 2.5)
    assert scenario.description == "a"


@pytest.mark.parametrize("number", ["1e2", "100", "1.0e2", "1E+2", "+1e2", "0.1e3", "100."])
def test_numbers_are_those_of_yaml_1_2(number: str, tmp_path: Path) -> None:
    source = Path(written(tmp_path))
    source.write_text(source.read_text().replace("duration_s: 60.0", f"duration_s: {number}"))

    assert loaded(str(source)).duration_s == 100.0
    assert loaded("smoke-4", parse_assignment(f"duration_s={number}")).duration_s == 100.0


@pytest.mark.parametrize("word", ["e5", "1e", ".", "+", "1.2.3", "e"])
def test_words_that_look_like_numbers_stay_words(word: str) -> None:
    assert loaded("smoke-4", parse_assignment(f"description={word}")).description == word


def test_another_shape_comes_without_the_old_placement() -> None:
    assert loaded("demo", shape_override("hw_2_square")).shape.scale == 1.0


def test_a_path_is_a_file_and_a_word_is_a_name() -> None:
    assert shape_override("formation_2").value == {"name": "formation_2"}
    assert shape_override("here/my.json").value == {"file": str(Path("here/my.json").absolute())}
    assert map_override("arena_main").value == {"name": "arena_main"}


@pytest.mark.parametrize(
    ("counts", "total", "expected"),
    [
        ((17, 17, 16), 50, (17, 17, 16)),
        ((17, 17, 16), 25, (9, 8, 8)),
        ((4, 4, 4), 13, (5, 4, 4)),
        ((1, 0, 3), 8, (2, 0, 6)),
        ((17, 17, 16), 1, (1, 0, 0)),
        ((1, 2), 3000, (1000, 2000)),
    ],
)
def test_rescaling_keeps_the_proportions(counts: tuple[int, ...], total: int, expected: tuple[int, ...]) -> None:
    assert rescaled_counts(counts, total) == expected


def test_the_number_of_agents_rescales_the_mix() -> None:
    scenario = loaded("formation-50", Override("--agents 25", ROBOT_COUNT, 25))

    assert [group.count for group in scenario.robots.types] == [9, 8, 8]


def test_an_error_names_the_option_that_is_to_blame() -> None:
    with pytest.raises(ConfigError, match=r"^--set loss: sim\.radio\.loss: must be"):
        loaded("demo", parse_assignment("seed=4"), parse_assignment("loss=7"))


def test_the_place_of_a_key_is_the_option_that_set_it_or_the_file() -> None:
    origin = Origin("a.yaml", (Override("--shape x", "shape", {}), Override("--set loss", "sim.radio.loss", 0.1)))

    assert origin.of("shape") == "--shape x"
    assert origin.of("sim") == "--set loss: sim"
    assert origin.of("map") == "a.yaml: map"


@pytest.mark.parametrize(("at_s", "tick"), [(0.0, 0), (0.5, 1), (0.7, 2), (30.0, 60)])
def test_an_event_happens_at_the_first_tick_that_is_not_before_it(at_s: float, tick: int) -> None:
    scenario = loaded("demo", parse_assignment(f"events=[{{at_s: {at_s}, kill: [3, 7]}}]"))

    assert scenario.deaths == {3: tick, 7: tick}


def test_the_mission_computer_can_be_switched_off() -> None:
    scenario = loaded("demo", parse_assignment("events=[{at_s: 1, kill: [3]}, {at_s: 2, stop: mission_computer}]"))

    assert scenario.deaths == {3: 2, MISSION: 4}


@pytest.mark.parametrize(
    ("method", "task"),
    [
        ("bubble-packing", Task.GOALS),
        ("fractals", Task.GOALS),
        ("voronoi", Task.PARTITION),
        ("forces", Task.FORCES),
        ("forces-literal", Task.FORCES_LITERAL),
    ],
)
def test_the_method_decides_what_is_asked_of_the_robots(method: str, task: Task) -> None:
    scenario = loaded("demo", parse_assignment("mission.task=forces"), *method_overrides(method))

    assert (scenario.method, scenario.mission.asked) == (method, task)


def test_who_partitions_can_be_chosen_after_the_method() -> None:
    told = loaded("demo", *method_overrides("voronoi"), parse_assignment("mission.task=goals"))
    alone = loaded("demo", *method_overrides("fractals"), parse_assignment("mission.task=partition"))

    assert (told.method, told.mission.asked) == ("voronoi", Task.GOALS)
    assert (alone.method, alone.mission.asked) == ("fractals", Task.PARTITION)
