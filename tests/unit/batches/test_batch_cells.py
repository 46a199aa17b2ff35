from __future__ import annotations

import json
from pathlib import Path

import pytest
import shapely
from source_tree import ROOT

from batches.cells import BACKEND, BLOCK, STUDIES, Design, cells, runs, seeds_by_cell
from bringup.resolution import contour_of
from bringup.scenario_file import SCENARIOS, Override
from swarm_msgs_py.errors import ConfigError

METHODS = ("bubble-packing", "fractals")
SHAPES = ("formation_1", "formation_2")


def test_the_cross_product_is_complete_and_in_the_order_given() -> None:
    design = Design(scenarios=("smoke-4", "demo"), shapes=SHAPES[::-1], methods=METHODS, objectives=("total",))

    assert [(cell.place, cell.method, cell.objective) for cell in cells(design)] == [
        ((scenario, shape), method, "total")
        for scenario in ("smoke-4", "demo")
        for shape in SHAPES[::-1]
        for method in METHODS
    ]


def test_what_is_not_named_is_what_the_scenario_says() -> None:
    (cell,) = cells(Design(scenarios=("smoke-4",)))

    assert cell.place == ("smoke-4", "hw_2_square")
    assert cell.variant == cell.method == cell.scenario.mission.partition.method.value


def test_objectives_belong_to_the_name_where_they_are_compared() -> None:
    found = cells(Design(scenarios=("smoke-4",), methods=METHODS[:1], objectives=("total", "bottleneck")))

    assert [cell.variant for cell in found] == ["bubble-packing, total", "bubble-packing, bottleneck"]


def test_what_is_named_twice_is_run_once() -> None:
    assert len(cells(Design(scenarios=("smoke-4", "smoke-4"), methods=("fractals", "fractals")))) == 1


@pytest.mark.parametrize("key", ["duration_s", "success.hold_s"])
def test_any_other_setting_makes_another_cell(key: str) -> None:
    (one,), (other,) = (
        cells(Design(scenarios=("smoke-4",), overrides=(Override("test", key, value),))) for value in (20.0, 21.0)
    )

    assert one.key != other.key


def test_the_seed_of_the_scenario_makes_no_other_cell() -> None:
    (one,), (other,) = (
        cells(Design(scenarios=("smoke-4",), overrides=(Override("test", "seed", value),))) for value in (1, 2)
    )

    assert one.key == other.key


def test_a_shape_file_is_written_out_so_that_no_run_needs_it(tmp_path: Path) -> None:
    path = tmp_path / "kite.json"
    path.write_text(json.dumps([[0, -2], [2, 0], [0, 2], [-2, 0]]))
    (before,) = cells(Design(scenarios=("smoke-4",), shapes=(str(path),)))
    path.write_text(json.dumps([[0, -2], [2, 0], [0, 3], [-2, 0]]))
    (after,) = cells(Design(scenarios=("smoke-4",), shapes=(str(path),)))

    assert before.place == after.place == ("smoke-4", "kite")
    assert before.scenario.shape.file is None
    assert before.key != after.key  # results of the one are none of the other


def test_two_scenarios_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text((SCENARIOS / "smoke-4.yaml").read_text().replace("duration_s: 60.0", "duration_s: 61.0"))

    with pytest.raises(ConfigError, match="would both be called 'smoke-4, hw_2_square"):
        cells(Design(scenarios=("smoke-4", str(path))))


@pytest.mark.parametrize(
    ("change", "message"),
    [({"shapes": ("formation_9",)}, "formation_"), ({"scenarios": ("x",)}, "x")],
)
def test_what_does_not_exist_is_named(change: dict[str, tuple[str, ...]], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        cells(Design(**{"scenarios": ("smoke-4",), **change}))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "study"), [("coverage-ball", "for coverage use scripts/coverage"), ("assembly-1", "benchmarks/assembly_")]
)
def test_another_family_is_sent_to_its_own_study(name: str, study: str) -> None:
    assert all((ROOT / path).is_file() for path in " ".join(STUDIES.values()).split() if path != "and")
    with pytest.raises(ConfigError, match=rf"--scenario {name}: batches compare formations; .*{study}"):
        cells(Design(scenarios=(name,), overrides=(Override("--physics", BACKEND, "massdamper"),)))


def test_a_turn_depends_on_the_seed_and_not_on_the_method() -> None:
    design = Design(scenarios=("smoke-4",), methods=METHODS, is_turned=True)
    turns = {
        seed: {run.scenario.shape.rotation_deg for run in runs(cells(design), range(seed, seed + 1))} for seed in (1, 2)
    }

    assert [len(found) for found in turns.values()] == [1, 1]
    assert turns[1] != turns[2]
    straight = runs(cells(Design(scenarios=("smoke-4",))), range(1, 3))
    assert {run.scenario.shape.rotation_deg for run in straight} == {0.0}


def test_shapes_are_not_turned_into_obstacles() -> None:
    (cell,) = cells(Design(scenarios=("formation-50-ideal",), shapes=("formation_4",), is_turned=True))
    obstacles = [shapely.Polygon(obstacle.polygon()) for obstacle in cell.scenario.map.obstacles]
    found = [contour_of(run.scenario) for run in runs((cell,), range(1, 41))]  # every eighth draw meets an obstacle

    assert not any(shapely.Polygon(contour).intersects(obstacles).any() for contour in found)


def test_turned_cells_are_others_than_straight_ones() -> None:
    straight, turned = (cells(Design(scenarios=("smoke-4",), is_turned=turns))[0] for turns in (False, True))

    assert straight.key != turned.key
    assert (straight.is_turned, turned.is_turned) == (False, True)


def test_a_scenario_of_several_shapes_is_not_turned() -> None:
    with pytest.raises(ConfigError, match="--turns: sequence-50 has several shapes"):
        cells(Design(scenarios=("sequence-50",), is_turned=True))


def test_seeds_are_found_in_the_keys_of_runs() -> None:
    (cell,) = cells(Design(scenarios=("smoke-4",)))
    keys = [run.key for run in runs((cell,), range(9, 12))]

    assert seeds_by_cell([*reversed(keys), "something else"]) == {cell.key: [9, 10, 11]}


def test_every_run_comes_once_and_in_blocks() -> None:
    found = cells(Design(scenarios=("smoke-4",), methods=METHODS))
    planned = list(runs(found, range(3, 3 + BLOCK + 2)))

    assert len({run.key for run in planned}) == len(planned) == 2 * (BLOCK + 2)
    assert [run.cell.method for run in planned] == [
        *([METHODS[0]] * BLOCK),
        *([METHODS[1]] * BLOCK),
        *([METHODS[0]] * 2),
        *([METHODS[1]] * 2),
    ]
