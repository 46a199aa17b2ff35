import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from shapely import Polygon

from mission_computer.shape import CoordinateUnit, check_inside, library_names, load_shape
from mission_computer.shape.library import library_points
from mission_computer.shape.validation import VERTICES_MAX
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, boundary_center, signed_area

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4]]
RING = [*SQUARE, [0, 0]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}
FEATURE = {"type": "Feature", "properties": {"name": "yard"}, "geometry": POLYGON}


@pytest.mark.parametrize("name", library_names())
def test_every_library_shape_is_a_counter_clockwise_contour(name: str) -> None:
    contour = load_shape(name)

    assert signed_area(contour) > 0.0
    assert not np.array_equal(contour[0], contour[-1])


# Areas and perimeters that table 4.3 of the thesis prints for its constant-area shapes.
@pytest.mark.parametrize(
    ("name", "length"),
    [("iso_1_circle", 62.8), ("iso_2_rect", 82.8), ("iso_3_rect", 116.82), ("iso_4_free", 128.36)],
)
def test_constant_area_shapes_measure_as_in_the_thesis(name: str, length: float) -> None:
    contour = load_shape(name)

    assert signed_area(contour) == pytest.approx(314.0, rel=1e-3)
    assert Polygon(contour).length == pytest.approx(length, rel=1e-3)


def test_the_boundary_center_of_the_boomerang_lies_outside_it() -> None:
    assert_allclose(boundary_center(load_shape("formation_2")), [5.837, -5.7757], atol=1e-3)


@pytest.mark.parametrize(
    "document",
    [
        POLYGON,
        FEATURE,
        {"type": "FeatureCollection", "features": [FEATURE]},
        {"type": "MultiPolygon", "coordinates": [[RING]]},
        {"type": "GeometryCollection", "geometries": [{"type": "Point", "coordinates": [1, 1]}, POLYGON]},
        {"type": "Polygon", "coordinates": [[[x, y, 7.0] for x, y in RING]]},
        {"name": "yard", "vertices": SQUARE},
        SQUARE,
    ],
    ids=["polygon", "feature", "collection", "multi of one", "geometries", "with height", "vertices", "list"],
)
def test_a_file_may_hold_the_contour_in_many_forms(tmp_path: Path, document: object) -> None:
    file = tmp_path / "yard.json"
    file.write_text(json.dumps(document))

    assert_allclose(load_shape(file, unit=CoordinateUnit.METERS), SQUARE)
    assert_allclose(load_shape(str(file), unit=CoordinateUnit.METERS), SQUARE)


def test_points_may_be_given_directly_or_as_json_text() -> None:
    assert_allclose(load_shape(SQUARE), SQUARE)
    assert_allclose(load_shape(np.array(SQUARE, dtype=float)), SQUARE)
    assert_allclose(load_shape(json.dumps(SQUARE)), SQUARE)


def test_a_clockwise_contour_is_turned_around() -> None:
    assert signed_area(load_shape(SQUARE[::-1])) == 16.0


def test_repeated_vertices_are_dropped() -> None:
    doubled = [point for point in SQUARE for _ in range(2)]

    assert_allclose(load_shape([*doubled, SQUARE[0]]), SQUARE)


def test_scale_and_rotation_keep_the_center_and_translation_moves_it() -> None:
    contour = load_shape(SQUARE, scale=3.0, rotation=math.pi / 2, translation=(10.0, -1.0))

    assert_allclose(area_centroid(contour), [12.0, 1.0])
    assert_allclose(contour[0], [18.0, -5.0])  # (0, 0) is (-2, -2) from the center; turned (2, -2); times 3
    assert signed_area(contour) == pytest.approx(9 * 16.0)


def test_a_contour_with_many_vertices_is_thinned_for_the_radio_and_keeps_its_area() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)
    wavy = (10.0 + np.cos(5 * angle))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])

    contour = load_shape(wavy)

    assert len(contour) <= VERTICES_MAX
    assert signed_area(contour) == pytest.approx(signed_area(wavy), rel=1e-3)


def test_a_shape_beyond_the_arena_is_refused_with_the_vertex_that_is_farthest_out() -> None:
    contour = load_shape(SQUARE, translation=(47.0, 0.0))

    check_inside(contour, (-50.0, -50.0, 51.0, 50.0), "yard")
    with pytest.raises(ShapeError, match=r"yard: vertex \(51, [04]\) is 1 m outside the arena.*move or shrink"):
        check_inside(contour, (-50.0, -50.0, 50.0, 50.0), "yard")


NAN, INF = math.nan, math.inf

BAD_POINTS = {
    "no points": ([], "only 0 different vertices"),
    "two points": ([[0, 0], [1, 1]], "only 2 different vertices; a contour needs at least 3"),
    "one point thrice": ([[1, 1]] * 3, "only 1 different vertices"),
    "nan": ([[0, 0], [NAN, 1], [1, 1]], r"vertex 2 is \(nan, 1\).*finite"),
    "infinite": ([[0, 0], [1, 0], [1, INF]], r"vertex 3 is \(1, inf\)"),
    "crossing": ([[0, 0], [4, 4], [4, 0], [0, 4]], r"crosses or touches itself at \(2\.00, 2\.00\)"),
    "touching": ([[0, 0], [4, 0], [2, 2], [4, 4], [0, 4], [2, 2]], r"touches itself at \(2\.00, 2\.00\)"),
    "on a line": ([[0, 0], [1, 1], [2, 2], [3, 3]], "encloses no area"),
    "a thin sliver": ([[0, 0], [100, 0], [100, 1e-4], [0, 1e-4]], "encloses an area of only 0.01 m2"),
    "three numbers": ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], r"vertex 1 is \[0, 0, 0\]; .*two numbers"),
    "text": ([[0, 0], ["a", 1], [1, 1]], r"vertex 2 is \['a', 1\]"),
    "flags": ([[0, 0], [True, 1], [1, 1]], "vertex 2 is"),
    "flat list": ([0, 0, 1, 0, 1, 1], "vertex 1 is 0;"),
    "far away": ([[0, 0], [1e9, 0], [0, 1e9]], "out of reach"),
}


@pytest.mark.parametrize(("points", "complaint"), BAD_POINTS.values(), ids=BAD_POINTS)
def test_points_that_are_no_shape_are_refused_in_one_line(points: list[list[float]], complaint: str) -> None:
    with pytest.raises(ShapeError, match=complaint) as caught:
        load_shape(points)

    assert str(caught.value).startswith("inline shape: ")
    assert "\n" not in str(caught.value)


CROSSING_HOLE = {"type": "Polygon", "coordinates": [RING, [[3, 1], [6, 1], [6, 2], [3, 1]]]}

BAD_FILES = {
    "not json": ("x: 1", "not JSON .line 1, column 1."),
    "number": ("7", "expected a list of .x, y. points"),
    "unknown object": ('{"points": []}', "neither GeoJSON .no 'type'. nor a shape with 'vertices'"),
    "line": ('{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}', "holds no polygon; give a Polygon"),
    "hole across the edge": (json.dumps(CROSSING_HOLE), r"Self-intersection.*holes must lie inside"),
    "empty": ('{"type": "Polygon", "coordinates": []}', "the polygon is empty"),
    "ring missing": (json.dumps({"type": "Polygon", "coordinates": RING}), "vertex 1 is|must be a list of rings"),
    "bare ring": ('{"type": "Polygon", "coordinates": [7]}', "must be a list of rings"),
    "no features": ('{"type": "FeatureCollection"}', "not valid GeoJSON"),
    "huge number": (f"[[0, 0], [1, 0], [1, 1{'0' * 400}]]", "too large"),
    "deep nesting": ("[" * 100_000, "not JSON|expected|vertex"),
}


@pytest.mark.parametrize(("text", "complaint"), BAD_FILES.values(), ids=BAD_FILES)
def test_files_that_hold_no_shape_are_refused_by_name(tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "bad.geojson"
    file.write_text(text)

    with pytest.raises(ShapeError, match=complaint) as caught:
        load_shape(file, unit=CoordinateUnit.METERS)

    assert str(caught.value).startswith(f"{file}: ")


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "shape.json"
    file.write_bytes(b"\x89PNG\xff\xfe")

    with pytest.raises(ShapeError, match="not a text file"):
        load_shape(file)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match=r"nowhere\.json: no such file; give a library name"):
        load_shape(tmp_path / "nowhere.json")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ShapeError, match=r"cannot be read .Is a directory."):
        load_shape(tmp_path)


def test_an_unknown_name_is_answered_with_the_nearest_one() -> None:
    with pytest.raises(ShapeError, match=r"'formaton_2' is neither .*; did you mean 'formation_2'\?"):
        load_shape("formaton_2")


def test_a_name_unlike_all_others_is_answered_with_the_list() -> None:
    with pytest.raises(ShapeError, match=r"choose from: formation_1, .*iso_4_free"):
        load_shape("zzz")


@pytest.mark.parametrize("scale", [0.0, -1.0, NAN, INF])
def test_a_scale_that_is_no_size_is_refused(scale: float) -> None:
    with pytest.raises(ShapeError, match="shape 'formation_1': scale must be"):
        load_shape("formation_1", scale=scale)


def test_library_points_are_those_of_the_file() -> None:
    assert library_points("hw_5_line").tolist() == [[-0.86, -0.22], [0.86, -0.22], [0.86, 0.22], [-0.86, 0.22]]
