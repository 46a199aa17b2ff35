from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest
from recorded_runs import busy_run, made_run, run_in_space, run_of_points, run_on_lattice

from reports.page import ASSETS, report_page
from reports.replay_data import ROBOT_FRAMES_MAX, frame_rows, replay_data
from reports.run_record import RunRecord
from reports.views import VIEWS, view_of
from swarm_msgs_py.errors import ConfigError

LIMIT_BYTES = 5_000_000


def test_a_run_of_50_robots_and_300_ticks_in_which_nothing_stays_the_same_fits_into_5_mb() -> None:
    assert len(report_page(busy_run(50, 300))) < LIMIT_BYTES


def test_a_run_ten_times_as_long_fits_as_well_and_says_what_is_left_out() -> None:
    page = report_page(busy_run(50, 3000)).decode()

    assert len(page) < LIMIT_BYTES
    assert re.search(r"A long run, shown coarser than it was.*: robots every 2 ticks, goals every \d+ ticks, ", page)
    assert '<p class="thinning"></p>' in report_page(made_run()).decode()


def test_long_runs_of_large_swarms_are_shown_with_fewer_frames_and_both_ends() -> None:
    record = made_run(robots=600, ticks=1000)
    rows = frame_rows(record)

    assert len(rows) * 600 <= ROBOT_FRAMES_MAX + 600
    assert rows[[0, -1]].tolist() == [0, 1000]
    data = replay_data(record)
    assert data["times"][-1] == 500.0
    assert data["alerts"][0][0] == int(np.searchsorted(rows, 500))


def test_the_page_names_no_other_place() -> None:
    page = report_page(made_run()).decode()

    own = re.sub(r"https://github\.com/leeoniya/uPlot", "", page)  # a comment in the chart library
    assert re.findall(r"(?:https?:)?//[a-z]+\.[a-z]", own) == []
    assert "{{" not in re.sub(r"<script.*?</script>", "", page, flags=re.DOTALL)


def test_every_metric_stands_in_the_page_with_its_unit() -> None:
    record = made_run()
    rows = re.findall(r"<tr><th scope='row'>(.*?)</th><td>(.*?)</td><td>(.*?)</td></tr>", report_page(record).decode())

    table = {html.unescape(name): (value, unit) for name, value, unit in rows}
    assert set(table) == set(record.metrics)
    assert table["settling_time_s"] == ("4.5", "s")
    assert table["total_displacement_m"] == ("12", "m")
    assert table["achieved"] == ("yes", "")
    assert table["morph_latency_s"] == ("none", "")
    assert table["stage_settling_s"] == ("1, none", "s")


def test_equal_runs_give_equal_pages() -> None:
    assert report_page(made_run()) == report_page(made_run())


@pytest.mark.parametrize(
    ("record", "name"), [(made_run(), "plane"), (run_on_lattice(), "plane"), (run_in_space(), "space")]
)
def test_each_run_gets_the_view_that_fits_it(record: RunRecord, name: str) -> None:
    assert view_of(record).name == name


def test_of_a_run_without_them_robots_get_numbers_a_visible_size_and_the_period_of_its_ticks() -> None:
    record = run_of_points(robots=30)

    assert record.robots == tuple(range(30))
    assert record.period_s == pytest.approx(0.5)
    assert (record.radii > 0.1).all()
    assert record.mode_names == ("mode 0", "mode 1", "mode 2")
    assert view_of(record).name == "space"


def test_every_view_has_its_script_which_registers_it() -> None:
    for view in VIEWS:
        assert f"Swarm.views.{view.name} = class" in (ASSETS / f"{view.name}_view.js").read_text()


def test_a_folder_that_is_no_run_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"metrics\.json is missing; name a folder that launch_swarm\.py has written"):
        RunRecord.load(tmp_path)


@pytest.mark.parametrize("broken", ["metrics.json", "trajectories.npz"])
def test_a_damaged_run_is_refused_in_a_line(broken: str, tmp_path: Path) -> None:
    (tmp_path / "metrics.json").write_text("{}")
    (tmp_path / "scenario.yaml").write_text("name: x")
    np.savez(tmp_path / "trajectories.npz", **made_run().arrays)  # type: ignore[arg-type]
    (tmp_path / broken).write_bytes(b"half a fi")

    with pytest.raises(ConfigError, match="cannot be read"):
        RunRecord.load(tmp_path)


def test_a_run_of_another_version_is_refused_with_what_it_lacks(tmp_path: Path) -> None:
    (tmp_path / "metrics.json").write_text("{}")
    (tmp_path / "scenario.yaml").write_text("name: x")
    np.savez(tmp_path / "trajectories.npz", time=np.zeros(1))

    with pytest.raises(ConfigError, match="has no 'position', so another version wrote it"):
        RunRecord.load(tmp_path)
