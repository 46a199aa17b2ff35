from __future__ import annotations

from dataclasses import fields
from typing import Any

import pyarrow as pa
import pytest
from matplotlib.axes import Axes
from pyarrow import parquet

from batches.cells import Cell, Design, Run, cells, runs
from batches.comparison import Comparison
from batches.comparison_figure import comparison_figure
from batches.controls import controls
from batches.quantities import QUANTITIES, SHARE, Quantity
from batches.runs_table import runs_parquet
from batches.tables import SHORT_HEADER, as_csv, as_markdown, short_rows
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
    comparison = Comparison(both, results(both, first, second))

    found = comparison.difference(both[1], RATIO)
    assert found is not None
    assert found.mean == pytest.approx(0.4)
    assert found.count == 2
    assert comparison.difference(both[0], RATIO) is None


def test_runs_that_did_not_start_alike_are_no_pair(both: tuple[Cell, ...]) -> None:
    first = {1: record(1.0, starts="a"), 2: record(2.0, starts="b")}
    second = {1: record(1.5, starts="a"), 2: record(9.0, starts="other")}
    comparison = Comparison(both, results(both, first, second))

    found = comparison.difference(both[1], RATIO)
    assert found is not None
    assert (found.mean, found.count) == (0.5, 1)
    assert comparison.unlike_starts() == 1


def test_settling_is_told_in_bottleneck_times(both: tuple[Cell, ...]) -> None:
    comparison = Comparison(both, results(both, {1: record(1.0), 2: record(1.0, settled=None)}, {}))

    assert comparison.values(both[0], SETTLING) == {1: 1.2}


def test_a_run_that_was_refused_lowers_the_share(both: tuple[Cell, ...]) -> None:
    comparison = Comparison(both, results(both, {1: record(1.0), 2: record(None, achieved=False)}, {}))

    found = comparison.estimate(both[0], SHARE)
    assert found is not None
    assert (found.mean, found.count) == (0.5, 2)


def test_the_order_in_which_runs_finished_changes_nothing(both: tuple[Cell, ...]) -> None:
    numbers = {1: record(0.1), 2: record(0.2), 3: record(0.3)}
    forth = Comparison(both, results(both, numbers, {}))
    back = Comparison(both, results(both, dict(reversed(numbers.items())), {}))

    assert as_csv(forth) == as_csv(back)


def test_tables_say_what_the_numbers_are(both: tuple[Cell, ...]) -> None:
    first, second = {1: record(1.0), 2: record(3.0)}, {1: record(1.5), 2: record(3.5)}
    comparison = Comparison(both, results(both, first, second))
    text, lines = as_markdown(comparison, ["warning: mind this"]), as_csv(comparison).splitlines()

    assert "## smoke-4, hw_2_square" in text
    assert "**warning: mind this**" in text
    assert "|  | fractals | 2.5 | 1.41 | [-10.21, 15.21] | 3.5 | 2 | +0.5 [0.5, 0.5] | 2 |" in text
    assert "smoke-4,hw_2_square,fractals,total,displacement_ratio,2,2.5," in "\n".join(lines)
    assert [row[2] for row in short_rows(comparison)] == ["bubble-packing", "fractals"]


def test_how_many_settled_stands_beside_settling(both: tuple[Cell, ...]) -> None:
    runs_of_first = {1: record(1.0), 2: record(1.0, settled=None), 3: record(1.0)}
    rows = short_rows(Comparison(both, results(both, runs_of_first, {})))

    assert rows[0][SHORT_HEADER.index("settling / bottleneck (settled/runs)")] == "1.2 (2/3)"


def test_the_figure_says_how_many_settled(both: tuple[Cell, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    text = Axes.text

    def spy(self: Axes, x: float, y: float, s: str, **options: Any) -> Any:
        written.append(s)
        return text(self, x, y, s, **options)

    monkeypatch.setattr(Axes, "text", spy)
    comparison_figure(Comparison(both, results(both, {1: record(1.0), 2: record(1.0, settled=None)}, {})))

    assert "1/2" in written


def test_lattices_have_no_interval_and_draws_have(both: tuple[Cell, ...]) -> None:
    lattice, drawn = controls(both[0])

    for name in ("mesh_geometrical_cells", "gap_variation", "cell_area_variation"):
        of_lattice, of_draws = lattice.estimate(quantity(name)), drawn.estimate(quantity(name))
        assert of_lattice is not None
        assert (of_lattice.deviation, of_lattice.low, of_lattice.high) == (None, None, None)
        assert of_draws is not None
        assert of_draws.low is not None
        assert of_draws.low < of_draws.mean
    assert drawn.estimate(quantity("morph_latency_s")) is None


def test_the_summary_says_what_its_intervals_cover(both: tuple[Cell, ...]) -> None:
    text = as_markdown(Comparison(both, results(both, {1: record(1.0)}, {})))

    assert "What the intervals cover: random starts only." in text
    assert "`--turns`" in text


def test_the_figure_needs_a_result_and_no_more(both: tuple[Cell, ...]) -> None:
    assert comparison_figure(Comparison(both, {})) is None
    drawn = comparison_figure(Comparison(both, results(both, {1: record(None, achieved=False)}, {})))

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
