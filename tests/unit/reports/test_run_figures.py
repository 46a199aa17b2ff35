from __future__ import annotations

import io
import re
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from matplotlib.collections import EllipseCollection
from PIL import Image
from recorded_runs import made_run, run_in_space, run_of_points, run_of_shapes, run_on_lattice

from reports import plot_cli, scene
from reports.figures import blank, encoded, figure_names, make_figure
from reports.film import HOLD_S, FilmSpec, film_times, write_film
from reports.plot_cli import main
from reports.run_record import RunRecord

SPEC = FilmSpec(fps=4, speed=2.0, width_in=2.0, dpi=60)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run folder."""
    path = tmp_path_factory.mktemp("run")
    (path / "metrics.json").write_text('{"scenario": "made-up", "seed": 3, "achieved": true}')
    (path / "scenario.yaml").write_text("name: made-up\n")
    np.savez(path / "trajectories.npz", **made_run().arrays)  # type: ignore[arg-type]
    return path


def pixels(data: bytes) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(np.int64)


@pytest.mark.parametrize(("kind", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_equal_runs_give_equal_files_of_every_kind(kind: str, begins: bytes) -> None:
    first, second = (encoded(make_figure(made_run(), "formation"), kind) for _ in range(2))

    assert first.startswith(begins)
    assert first == second


def test_fonts_of_a_pdf_are_embedded_as_truetype() -> None:
    data = encoded(make_figure(made_run(), "modes"), "pdf")

    assert b"/FontFile2" in data
    assert b"/Type3" not in data


@pytest.mark.parametrize("name", figure_names(made_run()))
def test_every_figure_has_the_width_that_was_asked_for_and_something_in_it(name: str) -> None:
    shown = pixels(encoded(make_figure(made_run(), name, width_in=3.5), "png", dpi=100))

    assert shown.shape[1] == 350
    assert (np.ptp(shown, axis=-1) > 60).sum() > 100  # lines and circles in color


def test_circles_have_the_true_size_of_the_robots_and_are_where_those_were() -> None:
    record = made_run()
    axes = make_figure(record, "formation", at_s=5.0).axes[0]
    circles = next(found for found in axes.collections if isinstance(found, EllipseCollection))

    assert circles.get_widths() == pytest.approx(2.0 * record.arrays["coverage_radius"])
    assert np.asarray(circles.get_offsets()) == pytest.approx(record.edge_positions[10])
    assert axes.get_aspect() == 1.0


@pytest.mark.parametrize("record", [run_in_space(), run_of_points()])
def test_a_run_in_space_is_seen_from_above_and_from_the_side(record: RunRecord) -> None:
    above, side = make_figure(record, "overview").axes

    assert (above.get_ylabel(), side.get_ylabel()) == ("y [m]", "z [m]")


def test_one_robot_without_a_shape_is_drawn() -> None:
    assert pixels(encoded(make_figure(made_run(robots=1, ticks=3), "overview"), "png")).std() > 0.0


def test_a_film_shows_the_run_at_the_speed_that_was_asked_for() -> None:
    times = film_times(made_run(ticks=20), SPEC)  # ten seconds

    assert np.diff(times[: -round(HOLD_S * 4)]).max() <= 0.5 + 1e-9
    assert times[-1] == 10.0
    assert len(times) == 20 + 1 + round(HOLD_S * SPEC.fps)


@pytest.mark.parametrize("ending", ["mp4", "gif"])
def test_a_film_can_be_read_back_and_moves(ending: str, tmp_path: Path) -> None:
    path = tmp_path / f"run.{ending}"
    count = write_film(path, made_run(ticks=6), SPEC)
    frames = read_frames(path)

    assert len(frames) == count
    assert (np.abs(frames[0] - frames[-1]).sum(axis=-1) > 100).sum() > 20


def read_frames(path: Path) -> list[np.ndarray]:
    """Return the pictures of a film."""
    if path.suffix == ".gif":
        with Image.open(path) as film:
            found = []
            for number in range(film.n_frames):
                film.seek(number)
                repeats = round(film.info["duration"] * SPEC.fps / 1000)  # equal pictures are stored once
                found += [np.asarray(film.convert("RGB")).astype(np.int64)] * repeats
            return found
    reader = imageio_ffmpeg.read_frames(str(path))
    width, height = next(reader)["size"]
    return [np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3).astype(np.int64) for frame in reader]


def test_the_command_line_writes_every_file_that_it_is_asked_for(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = [tmp_path / name for name in ("a.png", "b.svg", "c.html")]
    code = main([str(folder), *(word for path in paths for word in ("--out", str(path))), "--figure", "localization"])

    assert code == 0
    assert capsys.readouterr().out.split() == [str(path) for path in paths]
    assert all(path.stat().st_size > 1000 for path in paths)


def test_without_a_name_the_overview_goes_into_the_run_folder(folder: Path) -> None:
    assert main([str(folder)]) == 0
    assert (folder / "overview.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--out", "x.jpg"], r"--out x\.jpg: what kind of file is that\? Name it \.png"),
        (["--out", "nowhere/x.png"], r"there is no folder nowhere"),
        (["--figure", "nix", "--out", "x.png"], r"--figure nix: not of this run; it has overview, arena"),
        (["--width", "0"], r"--width: expected a number from 1 to 40"),
        (["--fsp", "3"], r"--fsp: unknown option; did you mean '--fps'\?"),
    ],
)
def test_bad_input_is_one_line_and_code_2(
    options: list[str], complaint: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(folder), *options]) == 2

    error = capsys.readouterr().err
    assert re.search(complaint, error)
    assert error.startswith("error: ")
    assert error.count("\n") == 1


def test_a_run_that_ended_before_its_first_tick_cannot_be_filmed_but_drawn(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record = made_run()
    by_time = {name: values[:0] for name, values in record.arrays.items() if values.shape[:1] in {(20,), (81,)}}
    before = RunRecord(record.metrics, record.scenario, {**record.arrays, **by_time})
    (tmp_path / "metrics.json").write_text("{}")
    (tmp_path / "scenario.yaml").write_text("")
    np.savez(tmp_path / "trajectories.npz", **before.arrays)  # type: ignore[arg-type]

    assert main([str(tmp_path), "--out", str(tmp_path / "film.mp4")]) == 2
    assert "before its first tick" in capsys.readouterr().err
    assert main([str(tmp_path), "--out", str(tmp_path / "overview.png")]) == 0


def test_boats_are_squares_as_they_lie_beside_the_cells_of_their_structure() -> None:
    record, edge = run_on_lattice(), 4
    axes = blank(4.0, 1.0).subplots()
    scene.draw_ground(axes, record)
    scene.RobotMarks(axes, record).put(edge)
    cells, boats = ([path.vertices[:4] for path in drawn.get_paths()] for drawn in axes.collections)

    assert [cell.mean(axis=0) for cell in cells] == pytest.approx(record.arrays["target_cells"])
    places, yaws = record.edge_positions[edge], record.edge_states("yaw")[edge]
    for boat, place, yaw, radius in zip(boats, places, yaws, record.radii, strict=True):
        assert boat.mean(axis=0) == pytest.approx(place)
        front = boat[1] - boat[0]
        assert front == pytest.approx(2.0 * radius * np.array([np.cos(yaw), np.sin(yaw)]))


def test_a_solid_is_drawn_where_it_is() -> None:
    record = run_of_shapes()
    axes = blank(4.0, 1.0).subplots()

    for edge, number in ((3, 0), (9, 1)):
        drawn = scene.draw_surface(axes, record, edge, (0, 2)).get_xydata()
        wanted = record.arrays["surfaces"][number] + record.arrays["surface_shift"][edge]
        assert drawn == pytest.approx(wanted[:, [0, 2]])


def test_who_interrupts_a_drawing_sees_no_traceback(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_: RunRecord) -> bytes:
        raise KeyboardInterrupt

    monkeypatch.setattr(plot_cli, "report_page", interrupt)

    assert main([str(folder), "--out", str(tmp_path / "report.html")]) == 130
    assert not list(tmp_path.iterdir())
