import json
from pathlib import Path

import numpy as np
import pytest

from mission_computer.shape.arena import load_arena
from swarm_msgs_py.errors import ConfigError, ShapeError


def test_the_main_arena_is_the_thesis_field() -> None:
    arena = load_arena("arena_main")

    assert arena.bounds_m == (-50.0, -50.0, 50.0, 50.0)
    assert [obstacle.name for obstacle in arena.obstacles][:2] == ["block", "hexagon"]


def test_obstacle_outlines_are_counter_clockwise_arrays() -> None:
    for outline in (wall.polygon() for wall in load_arena("arena_main").obstacles):
        x, y = outline.T
        assert np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) > 0.0


def test_an_unknown_arena_is_answered_with_the_nearest_one() -> None:
    with pytest.raises(ConfigError, match=r"did you mean 'arena_main'\?"):
        load_arena("arena_mian")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("{", "not JSON .line 1"),
        ('{"name": "x"}', "bounds_m: missing"),
        ('{"name": "x", "bounds_m": [0, 0, 1, 1], "roster": {}}', "roster: unknown key"),
        ('{"name": "x", "bound_m": []}', "bound_m: unknown key; did you mean 'bounds_m'"),
    ],
)
def test_a_wrong_arena_file_is_refused_by_file_and_key(tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "yard.json"
    file.write_text(text)

    with pytest.raises(ConfigError, match=f"yard.json: .*{complaint}|yard.json: {complaint}"):
        load_arena(file)


def test_a_missing_arena_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere\.json: cannot be read"):
        load_arena(tmp_path / "nowhere.json")


def test_a_self_crossing_obstacle_is_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "yard.json"
    bow = {"name": "bow", "vertices_m": [[0, 0], [1, 1], [1, 0], [0, 1]]}
    file.write_text(json.dumps({"name": "x", "bounds_m": [0, 0, 9, 9], "obstacles": [bow]}))

    with pytest.raises(ShapeError, match=r"obstacle 'bow': .*crosses"):
        tuple(wall.polygon() for wall in load_arena(file).obstacles)
