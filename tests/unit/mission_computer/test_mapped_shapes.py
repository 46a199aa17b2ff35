"""Shapes from maps: GeoJSON with holes, parts and neighbors, in meters or in degrees."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from shapely import Point, Polygon

from mission_computer.shape import CoordinateUnit, Placement, load_shape, placed_shape
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import area_centroid, signed_area

METERS, DEGREES = CoordinateUnit.METERS, CoordinateUnit.DEGREES
OUTER = [[0, 0], [10, 0], [10, 8], [0, 8], [0, 0]]
HOLE = [[4, 3], [6, 3], [6, 5], [4, 5], [4, 3]]
SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
METERS_PER_DEGREE = math.pi / 180.0 * 6_371_008.8


def mapped(folder: Path, *rings: list[list[float]], **members: object) -> Path:
    """Write a GeoJSON file of several polygons without holes."""
    features = [{"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [ring]}} for ring in rings]
    file = folder / "map.geojson"
    file.write_text(json.dumps({"type": "FeatureCollection", "features": features, **members}))
    return file


def named(system: str) -> dict[str, object]:
    """Return the member that names a coordinate system."""
    return {"type": "name", "properties": {"name": system}}


def box(west: float, south: float, width: float, height: float) -> list[list[float]]:
    """Return a closed ring around a box."""
    east, north = west + width, south + height
    return [[west, south], [east, south], [east, north], [west, north], [west, south]]


def test_a_hole_is_opened_by_a_slit_and_stays_outside_of_the_shape(tmp_path: Path) -> None:
    file = tmp_path / "ring.geojson"
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [OUTER, HOLE]}))

    shape = Polygon(load_shape(file, unit=METERS))

    assert shape.is_valid
    assert shape.area == pytest.approx(80.0 - 4.0, abs=0.1)  # the slit takes 2 cm times 3 m
    assert not shape.contains(Point(5.0, 4.0))
    assert shape.contains(Point(2.0, 4.0))


def test_several_polygons_are_joined_by_bridges(tmp_path: Path) -> None:
    far = [[x + 20, y] for x, y in OUTER]
    file = tmp_path / "two.geojson"
    file.write_text(json.dumps({"type": "MultiPolygon", "coordinates": [[OUTER, HOLE], [far]]}))

    shape = Polygon(load_shape(file, unit=METERS))

    assert shape.area == pytest.approx(2 * 80.0 - 4.0, abs=0.4)
    assert shape.bounds == (0.0, 0.0, 30.0, 8.0)


def test_a_small_hole_in_a_map_stays(tmp_path: Path) -> None:
    yard = [[0, 0], [100, 0], [100, 100], [0, 100], [0, 0]]
    pit = [[50, 50], [50, 53], [53, 53], [53, 50], [50, 50]]
    file = tmp_path / "yard.geojson"
    file.write_text(json.dumps({"type": "Polygon", "coordinates": [yard, pit]}))

    assert signed_area(load_shape(file, unit=METERS)) == pytest.approx(
        10_000.0 - 9.0, abs=2.0
    )  # the slit to it takes a little


@pytest.mark.parametrize(
    ("neighbor", "area", "bounds"),
    [
        (box(4, 0, 2, 4), 24.0, (0, 0, 6, 4)),
        (box(4, 1, 3, 2), 22.0, (0, 0, 7, 4)),
        (box(2, 0, 4, 4), 24.0, (0, 0, 6, 4)),
        (SQUARE, 16.0, (0, 0, 4, 4)),
    ],
    ids=["whole edge", "part of an edge", "overlap", "twice the same"],
)
def test_polygons_that_touch_are_one(
    tmp_path: Path, neighbor: list[list[float]], area: float, bounds: tuple[float, ...]
) -> None:
    shape = Polygon(load_shape(mapped(tmp_path, SQUARE, neighbor), unit=METERS))

    assert shape.area == pytest.approx(area)  # no bridge adds to it
    assert_allclose(shape.bounds, bounds)


def test_a_neighbor_fills_the_hole_that_it_lies_in(tmp_path: Path) -> None:
    file = tmp_path / "enclave.geojson"
    file.write_text(json.dumps({"type": "MultiPolygon", "coordinates": [[OUTER, HOLE], [HOLE]]}))

    assert signed_area(load_shape(file, unit=METERS)) == pytest.approx(80.0)


@pytest.mark.parametrize(
    ("ring", "unit", "members"),
    [
        (box(8.0, 60.0, 0.5, 0.25), DEGREES, {}),
        (box(8.0, 60.0, 0.5, 0.25), None, {"crs": named("urn:ogc:def:crs:OGC:1.3:CRS84")}),
        (box(8.0, 60.0, 0.5, 0.25), None, {"crs": named("EPSG:4326")}),
    ],
    ids=["told", "CRS84", "WGS 84"],
)
def test_degrees_become_meters_on_the_ground(
    tmp_path: Path, ring: list[list[float]], unit: CoordinateUnit | None, members: dict[str, object]
) -> None:
    contour = load_shape(mapped(tmp_path, ring, **members), unit=unit)

    # At 60.125 degrees north a degree of longitude is that much of one of latitude.
    width, height = 0.5 * METERS_PER_DEGREE * math.cos(math.radians(60.125)), 0.25 * METERS_PER_DEGREE
    assert_allclose(np.ptp(contour, axis=0), [width, height], rtol=1e-9)
    assert_allclose(area_centroid(contour), [0.0, 0.0], atol=1e-6)


def test_a_yard_in_degrees_needs_no_word_about_it(tmp_path: Path) -> None:
    contour = load_shape(mapped(tmp_path, box(11.5, 0.0, 0.0004, 0.0002)))

    assert_allclose(np.ptp(contour, axis=0), [0.0004 * METERS_PER_DEGREE, 0.0002 * METERS_PER_DEGREE], rtol=1e-6)


@pytest.mark.parametrize(
    ("ring", "members"),
    [
        (box(500.0, 300.0, 20.0, 10.0), {}),
        (box(5.0, 3.0, 20.0, 10.0), {"crs": named("urn:ogc:def:crs:EPSG::32632")}),
    ],
    ids=["beyond all degrees", "projected system"],
)
def test_meters_need_no_word_where_they_cannot_be_degrees(
    tmp_path: Path, ring: list[list[float]], members: dict[str, object]
) -> None:
    contour = load_shape(mapped(tmp_path, ring, **members))

    assert_allclose([contour.min(axis=0), contour.max(axis=0)], [ring[0], ring[2]])


def test_a_country_in_degrees_may_be_given_a_size(tmp_path: Path) -> None:
    file = mapped(tmp_path, box(6.0, 47.0, 9.0, 8.0), box(15.0, 48.0, 4.0, 3.0))

    contour = placed_shape(file, Placement(area=300.0, center=(1.0, 2.0)), unit=DEGREES)

    assert signed_area(contour) == pytest.approx(300.0)
    width, height = np.ptp(contour, axis=0)
    assert width / height == pytest.approx(13.0 * math.cos(math.radians(51.0)) / 8.0)


def test_islands_to_both_sides_of_the_antimeridian_stay_neighbors(tmp_path: Path) -> None:
    file = mapped(tmp_path, box(179.999, 0.0, 0.001, 0.001), box(-180.0, 0.0, 0.001, 0.001))

    assert_allclose(np.ptp(load_shape(file, unit=DEGREES), axis=0) / METERS_PER_DEGREE, [0.002, 0.001], rtol=1e-6)


@pytest.mark.parametrize(
    ("ring", "unit", "complaint"),
    [
        (OUTER, None, "may be degrees or meters; give shape.unit=deg or shape.unit=m"),
        (box(500.0, 0.0, 9.0, 9.0), DEGREES, "are no degrees; give shape.unit=m"),
        (box(6.0, 47.0, 9.0, 8.0), DEGREES, "out of reach; .* or a size"),
    ],
    ids=["both", "beyond 180", "a country in its own size"],
)
def test_a_unit_that_is_not_clear_is_asked_for(
    tmp_path: Path, ring: list[list[float]], unit: CoordinateUnit | None, complaint: str
) -> None:
    with pytest.raises(ShapeError, match=rf"map\.geojson: .*{complaint}"):
        load_shape(mapped(tmp_path, ring), unit=unit)
