"""Solids know what is inside; their descriptions travel; what is no solid is refused in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from swarm_msgs_py.errors import FrameError, ShapeError
from swarm_msgs_py.geometry.solids.description import inlined, packed_description, solid_from, unpacked_description
from swarm_msgs_py.geometry.solids.mesh import TriangleMesh
from swarm_msgs_py.geometry.solids.sampling import interior_points, surface_points, volume
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for

BALL = {"kind": "ball", "radius_m": 2.0}
BOX = {"kind": "box", "center_m": [1.0, 0.0, 0.0], "size_m": [2.0, 4.0, 6.0]}
PRISM = {"kind": "prism", "corners_m": [[0, 0], [4, 0], [0, 4]], "bottom_m": -1.0, "top_m": 2.0}

SOLIDS: dict[str, tuple[dict[str, Any], float]] = {
    "ball": (BALL, 4.0 / 3.0 * np.pi * 8.0),
    "box": (BOX, 48.0),
    "prism": (PRISM, 24.0),
    "union": ({"kind": "union", "of": [BOX, {**BOX, "center_m": [2.0, 0.0, 0.0]}]}, 72.0),
    "intersection": ({"kind": "intersection", "of": [BOX, {**BOX, "center_m": [2.0, 0.0, 0.0]}]}, 24.0),
    "difference": ({"kind": "difference", "whole": BOX, "holes": [{**BOX, "center_m": [2.0, 0.0, 0.0]}]}, 24.0),
    "moved": ({"kind": "moved", "of": BOX, "offset_m": [9.0, 0.0, 0.0], "turn_xyzw": [0.0, 0.0, 0.6, 0.8]}, 48.0),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_has_its_volume_within_its_bounds(name: str) -> None:
    description, expected = SOLIDS[name]
    solid = solid_from(description)

    measured, error = volume(solid, 40_000, rng_for(0, name))

    lower, upper = solid.bounds
    points = interior_points(solid, 500, rng_for(1, name))
    assert abs(measured - expected) < 5.0 * error + 1e-9
    assert ((points >= lower) & (points <= upper)).all()
    assert not solid.contains(np.stack([lower - 0.1, upper + 0.1])).any()


@pytest.mark.parametrize("name", SOLIDS)
def test_a_description_travels_and_gives_the_same_solid(name: str) -> None:
    description, _ = SOLIDS[name]
    there = unpacked_description(packed_description(description))

    points = 12.0 * rng_for(2, name).normal(size=(500, 3))
    assert np.array_equal(solid_from(there).contains(points), solid_from(description).contains(points))


@pytest.mark.parametrize("name", ["ball", "box", "difference", "moved"])
def test_surface_points_are_on_the_surface(name: str) -> None:
    solid = solid_from(SOLIDS[name][0])
    points = surface_points(solid, 200, rng_for(3, name))

    nearby = points[:, None] + 1e-6 * np.concatenate([np.eye(3), -np.eye(3)])
    inside = solid.contains(nearby.reshape(-1, 3)).reshape(200, 6)
    assert (inside.any(axis=1) & ~inside.all(axis=1)).all()


def test_surface_points_are_spread_by_area() -> None:
    points = surface_points(solid_from(BOX), 4000, rng_for(4, "area"))

    on_top = np.isclose(np.abs(points[:, 2]), 3.0, atol=1e-6).mean()
    assert on_top == pytest.approx(2 * 8.0 / 88.0, abs=0.03)


def test_a_mesh_agrees_with_the_ball_that_it_approximates() -> None:
    sphere = trimesh.creation.icosphere(subdivisions=3, radius=2.0)
    mesh = TriangleMesh(np.array(sphere.vertices), np.array(sphere.faces))
    points = 1.5 * rng_for(5, "mesh").normal(size=(3000, 3))

    distances = np.linalg.norm(points, axis=1)
    clear = np.abs(distances - 2.0) > 0.05  # beyond the flattening of the facets
    assert np.array_equal(mesh.contains(points)[clear], distances[clear] < 2.0)
    assert mesh.bounds == pytest.approx(np.array([[-2.0] * 3, [2.0] * 3]))


def test_a_mesh_of_few_large_triangles_knows_its_cavities(tmp_path: Path) -> None:
    torus = trimesh.creation.torus(major_radius=3.0, minor_radius=1.0, major_sections=12, minor_sections=6)
    torus.export(tmp_path / "ring.stl")
    solid = solid_from(inlined({"kind": "mesh", "file": "ring.stl", "scale": 2.0}, tmp_path))

    assert solid.contains(np.array([[6.0, 0.0, 0.0], [0.0, 0.0, 0.0], [6.0, 0.0, 3.0]])).tolist() == [
        True,
        False,
        False,
    ]


def test_a_mesh_comes_from_an_obj_file_inside_a_combination(tmp_path: Path) -> None:
    trimesh.creation.box((2.0, 2.0, 2.0)).export(tmp_path / "cube.obj")
    plain = inlined({"kind": "union", "of": [{"kind": "mesh", "file": "cube.obj"}, BALL]}, tmp_path)

    assert "file" not in str(plain)
    assert solid_from(plain).contains(np.array([[0.9, 0.9, 0.9], [0.0, 0.0, 1.9], [0.9, 0.9, 1.9]])).tolist() == [
        True,
        True,
        False,
    ]


@pytest.mark.parametrize(
    ("description", "complaint"),
    [
        (3, "shape: expected keys and values"),
        ({"kind": "bowl"}, "shape: kind: 'bowl' is no solid; choose from: ball"),
        ({"kind": "ball"}, "shape: radius_m: missing"),
        ({"kind": "ball", "radius_m": -1.0}, "shape: radius_m: must be > 0 m, got -1"),
        ({"kind": "ball", "radius_m": 1.0, "colour": 1}, "shape: colour: unknown key"),
        ({"kind": "box", "size_m": [1.0, 2.0]}, "shape: size_m: expected 3 values, got 2"),
        ({"kind": "union", "of": []}, "shape: of: expected a list of at least one solid"),
        ({"kind": "union", "of": [BALL], "off": 1}, "shape: off: unknown key"),
        (
            {"kind": "union", "of": [BALL, {"kind": "ball", "radius_m": "x"}]},
            "shape: of[1].radius_m: expected a number",
        ),
        ({"kind": "difference", "holes": [BALL]}, "shape: whole: expected keys and values"),
        (
            {"kind": "intersection", "of": [BALL, {**BALL, "center_m": [9, 0, 0]}]},
            "shape: the parts of an intersection",
        ),
        ({**PRISM, "corners_m": [[0, 0], [1, 1], [1, 0], [0, 1]]}, "shape: the polygon is not simple"),
        ({**PRISM, "top_m": -2.0}, "shape: the top of a prism (-2 m)"),
        ({"kind": "moved", "of": BALL, "turn_xyzw": [0, 0, 0, 0]}, "shape: turn_xyzw: a quaternion of length 0"),
        ({"kind": "mesh", "vertices_m": [[0, 0, 0]], "faces": [[0, 1, 2]]}, "shape: 1 faces do not fit 1 vertices"),
        (
            {"kind": "mesh", "vertices_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]},
            "shape: the mesh is not closed",
        ),
    ],
)
def test_what_is_no_solid_is_refused_in_one_line(description: object, complaint: str) -> None:
    with pytest.raises(ShapeError) as refused:
        solid_from(description)

    assert str(refused.value).startswith(complaint)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["absent.stl", "shape: step", "broken.stl"])
def test_a_mesh_file_that_cannot_be_used_is_refused_in_one_line(name: str, tmp_path: Path) -> None:
    (tmp_path / "broken.stl").write_bytes(b"no mesh")

    with pytest.raises(ShapeError) as refused:
        inlined({"kind": "mesh", "file": name}, tmp_path)

    assert name in str(refused.value)
    assert "\n" not in str(refused.value)


def test_solids_within_solids_have_an_end() -> None:
    description: dict[str, Any] = BALL
    for _ in range(20):
        description = {"kind": "moved", "of": description}

    with pytest.raises(ShapeError, match="solids within solids"):
        solid_from(description)


@pytest.mark.parametrize("data", [b"", b"nonsense", packed_description(BALL)[:-3], packed_description(BALL) + b"x"])
def test_bytes_that_describe_no_solid_are_refused(data: bytes) -> None:
    with pytest.raises(FrameError):
        unpacked_description(data)


def test_a_shape_without_inside_is_refused_by_sampling() -> None:
    hollow: Solid = solid_from({"kind": "difference", "whole": BALL, "holes": [{"kind": "ball", "radius_m": 3.0}]})

    with pytest.raises(ShapeError, match="empty"):
        interior_points(hollow, 10, rng_for(6, "hollow"))
