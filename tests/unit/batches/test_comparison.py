from __future__ import annotations

from dataclasses import fields

import pyarrow as pa
import pytest
from pyarrow import parquet

from batches.cells import Cell, Design, Run, cells, runs
from batches.comparison import Comparison
from batches.comparison_figure import comparison_figure
from batches.quantities import QUANTITIES, SHARE, Quantity
from batches.runs_table import runs_parquet
from batches.tables import as_csv, as_markdown, short_rows
from bringup.results import FormationMetrics
from studies.campaign import Record

SEEDS = range(1, 5)
RATIO, SETTLING = QUANTITIES[0], QUANTITIES[1]


@pytest.fixture(scope="module")
def both() -> tuple[Cell, ...]:
    return cells(Design(scenarios=("smoke-4",), methods=("bubble-packing", "fractals")))


def record(ratio: float | None, *, starts: str = "a", achieved: bool = True, settled: float | None = 12.0) -> Record:
    metrics = {field.name: None for field in fields(FormationMetrics)}
    own = {"scenario": "smoke-4", "achieved": achieved, "collisions": 0, "displacement_ratio": ratio}
    return {
        "metrics": {**metrics, **own, "settling_time_s": settled, "bottleneck_time_s": 10.0},
        "starts": starts,
        "timing": {"wall_time_s": 1.5, "run_s": 2.0},
    }


def results(both: tuple[Cell, ...], *of_cells: dict[int, Record]) -> dict[str, Record]:
    return {Run(cell, seed).key: found for cell, own in zip(both, of_cells, strict=True) for seed, found in own.items()}


def quantity(name: str) -> Quantity:
    return next(each for each in QUANTITIES if each.name == name)


def test_a_difference_is_of_pairs_and_from_the_first_method(both: tuple[Cell, ...]) -> None:
    first = {1: record(1.0, starts="a"), 2: record(2.0, starts="b"), 3: record(9.0, starts="c")}
    second = {2: record(2.5, starts="b"), 1: record(1.3, starts="a"), 4: record(7.0, starts="d")}
    comparison = Comparison(both, SEEDS, results(both, first, second))

    found = comparison.difference(both[1], RATIO)
    assert found is not None
    assert found.mean == pytest.approx(0.4)
    assert found.count == 2
    assert comparison.difference(both[0], RATIO) is None


def test_runs_that_did_not_start_alike_are_no_pair(both: tuple[Cell, ...]) -> None:
    first = {1: record(1.0, starts="a"), 2: record(2.0, starts="b")}
    second = {1: record(1.5, starts="a"), 2: record(9.0, starts="other")}
    comparison = Comparison(both, SEEDS, results(both, first, second))

    found = comparison.difference(both[1], RATIO)
    assert found is not None
    assert (found.mean, found.count) == (0.5, 1)
    assert comparison.unlike_starts() == 1


def test_settling_is_told_in_bottleneck_times(both: tuple[Cell, ...]) -> None:
    comparison = Comparison(both, SEEDS, results(both, {1: record(1.0), 2: record(1.0, settled=None)}, {}))

    assert comparison.values(both[0], SETTLING) == {1: 1.2}


def test_a_run_that_was_refused_lowers_the_share(both: tuple[Cell, ...]) -> None:
    comparison = Comparison(both, SEEDS, results(both, {1: record(1.0), 2: record(None, achieved=False)}, {}))

    found = comparison.estimate(both[0], SHARE)
    assert found is not None
    assert (found.mean, found.count) == (0.5, 2)


def test_the_order_in_which_runs_finished_changes_nothing(both: tuple[Cell, ...]) -> None:
    numbers = {1: record(0.1), 2: record(0.2), 3: record(0.3)}
    forth = Comparison(both, SEEDS, results(both, numbers, {}))
    back = Comparison(both, SEEDS, results(both, dict(reversed(numbers.items())), {}))

    assert as_csv(forth) == as_csv(back)


def test_tables_say_what_the_numbers_are(both: tuple[Cell, ...]) -> None:
    first, second = {1: record(1.0), 2: record(3.0)}, {1: record(1.5), 2: record(3.5)}
    comparison = Comparison(both, SEEDS, results(both, first, second))
    text, lines = as_markdown(comparison, ["warning: mind this"]), as_csv(comparison).splitlines()

    assert "## smoke-4, hw_2_square" in text
    assert "**warning: mind this**" in text
    assert "|  | fractals | 2.5 | 1.41 | [-10.21, 15.21] | 3.5 | 2 | +0.5 [0.5, 0.5] | 2 |" in text
    assert "smoke-4,hw_2_square,fractals,total,displacement_ratio,2,2.5," in "\n".join(lines)
    assert [row[2] for row in short_rows(comparison)] == ["bubble-packing", "fractals"]


def test_the_figure_needs_a_result_and_no_more(both: tuple[Cell, ...]) -> None:
    assert comparison_figure(Comparison(both, SEEDS, {})) is None
    drawn = comparison_figure(Comparison(both, SEEDS, results(both, {1: record(None, achieved=False)}, {})))

    assert drawn is not None
    assert drawn.startswith(b"\x89PNG")


def test_the_table_of_runs_has_every_metric_in_a_type_of_its_own(both: tuple[Cell, ...]) -> None:
    records = results(both, {2: record(None, settled=None)}, {1: record(1.25)})
    versions = {key: f"v{index}" for index, key in enumerate(records)}
    data = runs_parquet(runs(both, SEEDS), records, versions)

    table = parquet.read_table(pa.BufferReader(data))
    assert {field.name for field in fields(FormationMetrics)} < set(table.schema.names)
    assert table.column("displacement_ratio").to_pylist() == [None, 1.25]
    assert table.schema.field("settling_time_s").type == pa.float64()
    assert table.column("code_version").to_pylist() == ["v0", "v1"]
    assert table.column("shape").to_pylist() == ["hw_2_square"] * 2
    assert table.column("wall_time_s").to_pylist() == [1.5, 1.5]
