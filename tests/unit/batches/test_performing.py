from __future__ import annotations

from dataclasses import fields

import pytest

from batches.cells import Cell, Design, Run, cells
from batches.performing import TIMING, perform
from bringup.layout import make_scene
from bringup.results import FormationMetrics
from bringup.scenario_file import Override
from studies.code_version import code_version

METHODS = ("bubble-packing", "fractals", "voronoi")


def of(scenario: str, *methods: str, **settings: object) -> tuple[Cell, ...]:
    overrides = tuple(Override("test", key.replace("__", "."), value) for key, value in settings.items())
    return cells(Design(scenarios=(scenario,), methods=methods, overrides=overrides))


def quick(*methods: str) -> tuple[Cell, ...]:
    return of("smoke-4", *methods, sim__physics__backend="massdamper")


def test_all_methods_start_alike() -> None:
    found = [perform(Run(cell, 5)) for cell in quick(*METHODS[:2])]

    assert found[0].starts == found[1].starts != ""
    assert found[0].metrics["displacement_lower_bound_m"] != found[1].metrics["displacement_lower_bound_m"]


@pytest.mark.parametrize("shape", ["formation_1", "formation_3"])
def test_starts_of_the_fifty_depend_on_the_seed_alone(shape: str) -> None:
    scenes = {
        tuple(robot.position for robot in make_scene(cell.scenario).robots)
        for cell in cells(Design(scenarios=("formation-50-ideal",), shapes=(shape,), methods=METHODS))
    }

    assert len(scenes) == 1


def test_a_run_has_every_metric_and_the_version_of_the_code() -> None:
    performed = perform(Run(quick("fractals")[0], 2))

    names = {field.name for field in fields(FormationMetrics)}
    assert performed.metrics.keys() == names - TIMING
    assert performed.timing.keys() == {*TIMING, "run_s"}
    assert performed.metrics["seed"] == 2
    assert performed.metrics["achieved"] is True
    assert performed.code == code_version()


def test_equal_runs_have_equal_metrics() -> None:
    (cell,) = quick("fractals")

    assert perform(Run(cell, 3)).metrics == perform(Run(cell, 3)).metrics
    assert perform(Run(cell, 3)).starts != perform(Run(cell, 4)).starts


def test_a_start_that_cannot_be_made_counts_as_not_achieved() -> None:
    (cell,) = of("smoke-4", robots__start__half_side_m=0.01)

    performed = perform(Run(cell, 1))

    assert performed.metrics["achieved"] is False
    assert str(performed.metrics["reason"]).startswith("refused: ")
    assert performed.metrics["displacement_ratio"] is None
    assert performed.starts == ""
