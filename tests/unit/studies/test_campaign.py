from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from studies.campaign import ResultFile, WorkerDiedError, completed
from studies.campaign_folder import RESULTS, locked
from studies.code_version import REPORTING, ROOT, code_version
from swarm_msgs_py.errors import ConfigError


def square(number: int) -> int:
    return number * number


def die(number: int) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_results_come_back_from_the_file(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    ResultFile(path, "v1").append("a", {"rms_m": 0.1 + 0.2, "achieved": None})

    assert ResultFile(path, "v1").records == {"a": {"rms_m": 0.1 + 0.2, "achieved": None}}


def test_a_line_that_a_crash_cut_off_costs_only_itself(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    file = ResultFile(path, "v1")
    file.append("a", {"rms_m": 1.0})
    file.append("b", {"rms_m": 2.0})
    path.write_text(path.read_text()[:-5])

    reopened = ResultFile(path, "v1")
    reopened.append("c", {"rms_m": 3.0})

    assert reopened.records.keys() == {"a", "c"}
    assert ResultFile(path, "v1").records == {"a": {"rms_m": 1.0}, "c": {"rms_m": 3.0}}


def test_results_of_other_code_are_known_as_such(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    ResultFile(path, "v1").append("a", {"rms_m": 1.0})
    ResultFile(path, "v2").append("b", {"rms_m": 2.0})

    assert ResultFile(path, "v2").outdated == {"a"}
    assert ResultFile(path, "v2").records.keys() == {"a", "b"}


def test_a_result_that_was_made_anew_is_not_outdated(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    ResultFile(path, "v1").append("a", {"rms_m": 1.0})
    file = ResultFile(path, "v2")
    file.append("a", {"rms_m": 2.0})

    assert file.outdated == ResultFile(path, "v2").outdated == set()
    assert ResultFile(path, "v1").outdated == {"a"}
    assert ResultFile(path, "v2").records == {"a": {"rms_m": 2.0}}


def test_a_warning_speaks_only_of_the_runs_that_are_wanted(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    for key in ("a", "b"):
        ResultFile(path, "v1").append(key, {"rms_m": 1.0})

    assert ResultFile(path, "v2").warning(["b", "c"]).startswith(f"warning: 1 of the results in {path}")
    assert ResultFile(path, "v2").warning(["c"]) == ""


@pytest.mark.parametrize(
    "line", ['{"run": "a"}', '{"run": "a", "result": {}}', '{"run": "a", "code": "v1", "result": 1}']
)
def test_a_short_line_counts_as_none(line: str, tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    path.write_text(f"{line}\n")

    assert ResultFile(path, "v1").records == {}


def test_without_a_path_results_are_kept_in_memory_only() -> None:
    file = ResultFile(None, "v1")
    file.append("a", {"rms_m": 1.0})

    assert file.records == {"a": {"rms_m": 1.0}}


@pytest.mark.parametrize("name", ["scripts/one.py", "scripts/scenarios/one.yaml", "ros_ws/src/shape/library/one.json"])
def test_any_edit_of_source_or_data_makes_another_version(name: str, tmp_path: Path) -> None:
    source = tmp_path / name
    source.parent.mkdir(parents=True)
    source.write_text("A: 1\n")
    before = code_version(tmp_path)
    source.write_text("A: 2\n")

    assert code_version(tmp_path) != before
    source.write_text("A: 1\n")
    assert code_version(tmp_path) == before


@pytest.mark.parametrize("name", ["scripts/scenarios/scenario.schema.json", "scripts/notes.md", "benchmarks/one.py"])
def test_what_no_run_reads_makes_no_other_version(name: str, tmp_path: Path) -> None:
    before = code_version(tmp_path)
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).write_text("{}")

    assert code_version(tmp_path) == before


def test_what_only_tells_of_runs_is_there_and_makes_no_other_version(tmp_path: Path) -> None:
    before = code_version(tmp_path)
    for name in REPORTING:
        assert (ROOT / name).is_file()
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("A = 1")

    assert code_version(tmp_path) == before


def test_another_method_of_an_installed_package_makes_another_version(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    site, project = tmp_path / "site", tmp_path / "project"
    metadata = site / "others_methods-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: others-methods\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[swarm.strategies]\nothers = others_methods.one:One\n")
    source = site / "others_methods" / "one.py"
    source.parent.mkdir()
    source.write_text("class One: ...\n")
    without = code_version(project)
    monkeypatch.syspath_prepend(site)
    before = code_version(project)
    source.write_text("class One: 'another'\n")
    after = code_version(project)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: others-methods\nVersion: 1.1\n")

    assert len({without, before, after, code_version(project)}) == 4


def test_a_lock_is_held_against_others_and_let_go(tmp_path: Path) -> None:
    with locked(tmp_path), pytest.raises(ConfigError, match="another process is writing results there"):
        locked(tmp_path).__enter__()

    with locked(tmp_path):
        assert (tmp_path / RESULTS).read_text() == ""


def test_folders_that_count_can_be_named(tmp_path: Path) -> None:
    (tmp_path / "benchmarks").mkdir()
    before = code_version(tmp_path, ["benchmarks"])
    (tmp_path / "benchmarks" / "one.py").write_text("A = 1")

    assert code_version(tmp_path, ["benchmarks"]) != before


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    path.write_bytes(b"\xff\xfe\x00")

    with pytest.raises(ConfigError, match="cannot be read"):
        ResultFile(path, "v1")


@pytest.mark.parametrize("workers", [1, 2])
def test_every_run_is_performed_once(workers: int) -> None:
    runs = list(range(5))

    assert sorted(completed(runs, square, workers)) == [(number, number**2) for number in runs]


def test_a_worker_that_is_killed_is_one_named_error() -> None:
    with pytest.raises(WorkerDiedError, match="run the same command again"):
        list(completed([1, 2], die, 2))
