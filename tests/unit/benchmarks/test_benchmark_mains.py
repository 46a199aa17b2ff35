"""Every benchmark from command line to table, as small as it can be made: what it measures may have moved on."""

from __future__ import annotations

from pathlib import Path

import assembly_maps
import assembly_pool
import assignment
import bench_agent
import bench_forces
import bench_mesh
import bench_vision
import bench_world
import camera_arena
import force_formations
import formation
import mesh_delivery
import moving_shapes
import partition_quality
import pytest
import robustness
import thesis_comparison
from small_batch import batch
from source_tree import ROOT

PARTS = {"drawing", "result_file", "robustness_report", "robustness_watch", "tables"}
"""What is no benchmark by itself."""
RUN_HERE = (
    *(assembly_maps, assembly_pool, assignment, bench_agent, bench_forces, bench_mesh, bench_vision, bench_world),
    *(camera_arena, force_formations, formation, mesh_delivery, moving_shapes, partition_quality, robustness),
    thesis_comparison,
)


def test_the_arena_is_run_as_a_user_would(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    words = ["--seeds", "1", "--random-starts", "--out", str(tmp_path / "runs.jsonl")]
    settings = ("sim.physics.backend=massdamper", "duration_s=2", "stages=[{shape: {name: hw_2_square}, at_s: 1.0}]")
    words += [word for setting in (*settings, "success.hold_s=0.5") for word in ("--set", setting)]

    assert camera_arena.main(words) == 1  # nobody is so fast
    out = capsys.readouterr().out
    assert "| hw_2_square | 0 of 1 |" in out
    assert "| runs achieved, collisions | 0 of 1, 0 |" in out
    assert camera_arena.main(words) == 1
    assert capsys.readouterr().out == out  # from the file


def test_assignment_compares_both_objectives(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assignment, "SHAPES", ("formation_4",))

    assert assignment.main(["--seeds", "1"]) == 0
    assert "| formation_4 | 1 |" in capsys.readouterr().out


def test_agent_is_timed_by_parts(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    bench_agent.main(["--scenario", "smoke-4", "--ticks", "5", "--figure", str(tmp_path / "agent.png")])

    assert "| agent: the whole step | 4.0 |" in capsys.readouterr().out
    assert (tmp_path / "agent.png").read_bytes().startswith(b"\x89PNG")


def test_forces_are_timed(capsys: pytest.CaptureFixture[str]) -> None:
    bench_forces.main(1)

    assert "| all five forces |" in capsys.readouterr().out


def test_mesh_is_timed(capsys: pytest.CaptureFixture[str]) -> None:
    bench_mesh.main(4, 5)

    assert capsys.readouterr().out


def test_vision_is_timed(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_vision, "IMAGES", 2)
    monkeypatch.setattr(bench_vision, "SIZES", ((640, 480),))

    assert bench_vision.main([]) in {0, 1}  # a busy machine may be slow

    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert [row[0] for row in rows] == ["640x480"] * 2
    for row in rows:
        take, median, percentile, largest, found = map(float, row[-5:])
        assert take > 0.0
        assert 0.0 < median <= percentile <= largest
        assert found >= 5 * 10  # of the ten images for the calibration, in which nothing is hidden


def test_vision_that_takes_too_long_is_told_by_the_exit_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_vision, "IMAGES", 1)
    monkeypatch.setattr(bench_vision, "SIZES", ((640, 480),))
    monkeypatch.setattr(bench_vision, "KINDS", {"hard": bench_vision.KINDS["hard"]})
    monkeypatch.setattr(bench_vision, "LIMIT_MS", 0.0)

    assert bench_vision.main(["--renderer", "raster"]) == 1


def test_world_is_timed_on_both_back_ends(capsys: pytest.CaptureFixture[str]) -> None:
    bench_world.main((4,), 2)

    assert [line.split()[:2] for line in capsys.readouterr().out.splitlines()[1:]] == [
        ["bullet", "4"],
        ["massdamper", "4"],
    ]


def test_forces_form_a_shape(capsys: pytest.CaptureFixture[str]) -> None:
    force_formations.main(["--law", "forces", "--shapes", "formation_1", "--seeds", "1", "--deadline", "10"])

    assert "| forces | formation_1 | 0/1 |" in capsys.readouterr().out


def test_formation_is_run_as_a_user_would(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(formation, "SPEED_CASES", formation.SPEED_CASES[-1:])

    assert formation.main(["--scenario", "smoke-4", "--seeds", "1", "--table", "speed"]) == 0
    assert "| in-process, mass-damper |" in capsys.readouterr().out


def test_delivery_is_counted(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mesh_delivery, "ARENAS", ("open",))
    monkeypatch.setattr(mesh_delivery, "LOSSES", (0.0,))

    assert mesh_delivery.main(["--seeds", "1", "--robots", "5", "--processes", "1"]) in {0, 1}
    assert "open" in capsys.readouterr().out


def test_moving_shapes_are_followed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    square = tmp_path / "square.json"
    square.write_text("[[-1, -1], [1, -1], [1, 1], [-1, 1]]")
    monkeypatch.setitem(moving_shapes.MOTIONS, "short", (str(square), "{scale: 1.1, over_s: 5.0}"))
    words = ["--scenario", "smoke-4", "--methods", "voronoi", "--motions", "short", "--seeds", "1"]

    assert moving_shapes.main([*words, "--out", str(tmp_path / "runs.jsonl")]) == 0
    assert "| short | voronoi | 1 | 1 | 0 |" in capsys.readouterr().out


def test_partitions_are_compared(capsys: pytest.CaptureFixture[str]) -> None:
    assert partition_quality.main(["--shapes", "formation_1", "--turns", "1", "--seeds", "1"]) == 0
    assert "| formation_1 | (random points) |" in capsys.readouterr().out


def test_robustness_is_watched(capsys: pytest.CaptureFixture[str]) -> None:
    assert robustness.main(["split", "--seeds", "1", "--processes", "1", "--set", "duration_s=2"]) == 1
    assert "| split and merge | 1 | 0 | 0 |" in capsys.readouterr().out


def test_a_batch_is_set_beside_the_thesis(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    batch(tmp_path, "--seeds", "2")
    capsys.readouterr()

    assert thesis_comparison.main([str(tmp_path)]) == 0
    assert "| fractals | displacement |" in capsys.readouterr().out


def test_boats_assemble_on_the_grid(capsys: pytest.CaptureFixture[str]) -> None:
    assert assembly_maps.main(["--maps", "1", "--seeds", "1"]) == 0
    assert "| map_1 | genderless | 1 of 1 |" in capsys.readouterr().out


def test_boats_assemble_in_the_pool_and_finished_runs_are_kept(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "runs.jsonl"
    words = ["--maps", "boats_4_line", "--docks", "genderless", "--bodies", "planar", "--seeds", "1", "--out", str(out)]
    assert assembly_pool.main(words) == 0
    table, kept = capsys.readouterr().out, out.read_text()

    assert assembly_pool.main(words) == 0
    assert "| boats_4_line | genderless | 1 of 1 | 4.0 (4) of 4 | 0 |" in table
    assert (capsys.readouterr().out, out.read_text()) == (table, kept)


def test_no_benchmark_is_left_out() -> None:
    run_here = {each.__name__ for each in RUN_HERE}
    files = {path.stem for path in (ROOT / "benchmarks").glob("*.py")}

    assert run_here == files - PARTS
