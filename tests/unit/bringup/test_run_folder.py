from __future__ import annotations

from pathlib import Path

import pytest

from bringup.run_folder import RunFolder, reserve_default
from bringup.scenario_file import load_scenario
from swarm_msgs_py.errors import ConfigError


def test_a_new_folder_is_made_with_its_parents(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "a" / "b")

    assert folder.write("x.txt", b"hello").read_bytes() == b"hello"
    assert sorted(path.name for path in (tmp_path / "a" / "b").iterdir()) == ["x.txt"]


def test_an_empty_folder_that_exists_will_do(tmp_path: Path) -> None:
    assert RunFolder(tmp_path).path == tmp_path


def test_a_folder_in_use_is_refused_and_left_alone(tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("data")

    with pytest.raises(ConfigError, match=r"--out .*: is not empty; give a new folder"):
        RunFolder(tmp_path)
    assert (tmp_path / "precious").read_text() == "data"


def test_a_file_in_the_way_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")

    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(ConfigError, match="cannot be written"):
            RunFolder(path)


def test_releasing_removes_what_was_made_and_nothing_else(tmp_path: Path) -> None:
    RunFolder(tmp_path / "a" / "b").release()

    assert list(tmp_path.iterdir()) == []


def test_releasing_keeps_results(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "a")
    folder.write("metrics.json", b"{}")
    folder.release()

    assert (tmp_path / "a" / "metrics.json").exists()


def test_a_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    folder.write("x", b"long old content")
    folder.write("x", b"new")

    assert (tmp_path / "x").read_bytes() == b"new"


def test_default_folders_of_one_second_have_different_names(tmp_path: Path) -> None:
    scenario, _ = load_scenario("smoke-4")
    paths = {reserve_default(scenario, tmp_path).path for _ in range(3)}

    assert len(paths) == 3
    assert all("-smoke-4-1" in path.name for path in paths)
