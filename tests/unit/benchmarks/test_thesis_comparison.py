"""Ratios of methods on equal starts, beside the thesis' and its ranking."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa
import pytest
from pyarrow import parquet
from thesis_comparison import main

SEEDS = range(1, 9)
STRONG = {seed: 1.0 + 0.1 * seed for seed in SEEDS}  # how hard each start is, for every method


def batch(folder: Path, displacements: Mapping[str, float], **others: float | None) -> Path:
    """Write runs on one shape whose displacement is a factor of the method times how hard the start is."""
    numbers = {
        **{"mesh_topological": 1.0, "mesh_geometrical": 0.1, "mesh_topological_interior": 0.1, "covered_fraction": 1.0},
        **{"settling_time_s": 100.0, "bottleneck_time_s": 100.0, "displacement_ratio": 1.0, "cell_area_variation": 0.1},
        **others,
    }
    rows = [
        {"shape": "formation_1", "method": method, "seed": seed, "achieved": True, "collisions": 0}
        | {"min_clearance_m": 0.1, **numbers, "total_displacement_m": factor * STRONG[seed]}
        for method, factor in displacements.items()
        for seed in SEEDS
    ]
    parquet.write_table(pa.Table.from_pylist(rows), folder / "runs.parquet")
    return folder


def line(text: str, start: str) -> str:
    (found,) = [row for row in text.splitlines() if row.startswith(start)]
    return found


def test_a_ratio_is_taken_start_by_start(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(batch(tmp_path, {"bubble-packing": 100.0, "forces": 110.0}))]) == 0

    # Starts differ by 64 %, the ratio on each does not: its interval has no width. 1889 m / 1750 m in the thesis.
    assert "1.100 [1.100, 1.100] (1.08) |" in line(capsys.readouterr().out, "| forces | displacement |")


def test_the_ranking_holds_when_the_worst_is_worse_than_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main([str(batch(tmp_path, {"bubble-packing": 100.0, "fractals": 104.0, "forces": 110.0}))])
    text = capsys.readouterr().out

    assert line(text, "| displacement | A | forces |").endswith("| holds |")
    assert line(text, "| eps_t | C | forces |").endswith("| A as bad, C/A = 1.000; B as bad, C/B = 1.000 |")


def test_the_ranking_names_who_is_worse_instead(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main([str(batch(tmp_path, {"bubble-packing": 100.0, "fractals": 125.0, "forces": 110.0}))])

    row = line(capsys.readouterr().out, "| displacement | A | forces |")
    assert row.endswith("| C is worse, A/C = 0.880 |")


def test_a_method_that_never_settled_has_no_settling_ratio(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main([str(batch(tmp_path, {"bubble-packing": 100.0, "forces-literal": 130.0}, settling_time_s=None))])
    text = capsys.readouterr().out

    assert line(text, "| forces-literal | settling |").endswith("| - |")
    assert line(text, "| formation_1 | forces-literal | 8 | 8 | 0 |")


def test_a_folder_without_a_batch_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path)]) == 2
    (message,) = capsys.readouterr().err.splitlines()
    assert str(tmp_path / "runs.parquet") in message
