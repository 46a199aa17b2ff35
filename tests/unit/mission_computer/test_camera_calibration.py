from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.testing import assert_allclose
from table_top import STARTS, YAWS, camera, picture

from mission_computer.vision.calibration import calibrate, find_marks, plane_maps
from swarm_msgs_py.markers import FloorMarks
from swarm_sim.camera.optics import make_optics
from swarm_sim.config import CameraConfig

MARKS = FloorMarks()
FLOOR = np.column_stack([MARKS.centers, np.zeros(4)])
EVERYWHERE = slice(None)


def test_marks_are_found_to_a_small_part_of_a_pixel() -> None:
    found = find_marks(picture().pixels)

    assert found is not None
    assert_allclose(found, camera().optics.project(FLOOR), atol=0.25)  # the grain of the floor


def test_marks_are_found_in_strongly_uneven_light() -> None:
    uneven = camera(seed=1, light_gradient=0.6, vignette=0.3)
    shot = uneven.take(0, 0.0, STARTS, YAWS)

    assert shot is not None
    found = find_marks(shot.pixels)
    assert found is not None
    assert_allclose(found, uneven.optics.project(FLOOR), atol=0.3)


@pytest.mark.parametrize("gap_px", [7, 8, 9])
def test_a_black_cover_right_beside_a_mark_does_not_shift_it(gap_px: int) -> None:
    undisturbed, image = find_marks(picture().pixels), picture()
    assert undisturbed is not None
    column, row = undisturbed[0].round().astype(int)
    image.pixels[row - 20 : row + 21, column + gap_px : column + 28] = 10

    found = find_marks(image.pixels)

    assert found is not None
    assert_allclose(found, undisturbed, atol=0.1)


@pytest.mark.parametrize("side", ["left", "top"])
def test_without_all_marks_there_is_no_view(side: str) -> None:
    pixels = picture().pixels
    if side == "left":
        pixels[:, :320] = 0
    else:
        pixels[:60] = 190

    assert find_marks(pixels) is None


def test_exact_marks_give_the_exact_place() -> None:
    optics = camera().optics

    place = calibrate(optics.project(FLOOR), optics.info, MARKS)

    assert place is not None
    assert place.error_px < 1e-4
    assert_allclose(-place.rotation.T @ place.translation, optics.position, atol=1e-5)
    assert_allclose(place.rotation, optics.rotation, atol=1e-5)


def test_marks_in_wrong_places_show_as_an_error() -> None:
    optics = camera().optics
    pixels = optics.project(FLOOR)
    pixels[0] += (25.0, 0.0)

    place = calibrate(pixels, optics.info, MARKS)

    assert place is None or place.error_px > 2.0


def test_the_map_of_a_plane_agrees_with_the_optics_of_the_simulator() -> None:
    """Two independent implementations of the same lens: OpenCV's here, our own there."""
    optics = camera().optics
    place = calibrate(optics.project(FLOOR), optics.info, MARKS)
    assert place is not None

    maps = plane_maps(place, [0.0, 0.12])

    pixels = np.array([(0, 0), (639, 0), (320, 240), (17, 401), (639, 479)])
    for height, plane in maps.items():
        points = optics.plane_points(optics.rays(pixels.astype(float)), height)
        shown, _ = plane.window(EVERYWHERE, EVERYWHERE)
        assert_allclose(shown[pixels[:, 1], pixels[:, 0]], points, atol=2e-5)


@pytest.mark.parametrize("distortion", [-0.15, 0.05])
@pytest.mark.parametrize(("width", "height"), [(320, 240), (1280, 960)])
def test_maps_from_few_points_are_those_of_every_pixel(distortion: float, width: int, height: int) -> None:
    config = CameraConfig(radial_distortion=distortion, width_px=width, height_px=height)
    optics = make_optics(config, np.random.default_rng(4))
    place = calibrate(optics.project(FLOOR), optics.info, MARKS)
    assert place is not None
    rows, columns = np.mgrid[:height:7, :width:7]

    plane = plane_maps(place, [0.12])[0.12]
    points, shown = plane.window(EVERYWHERE, EVERYWHERE)

    rays = place.rays(np.stack([columns, rows], axis=-1).reshape(-1, 2).astype(float))
    exact = place.plane_points(rays, 0.12).reshape(*rows.shape, 2)
    assert_allclose(points[rows, columns], exact, atol=1e-8)
    down, across = (np.asarray(np.gradient(points, axis=axis)) for axis in (0, 1))
    areas = np.abs(across[..., 0] * down[..., 1] - across[..., 1] * down[..., 0])
    assert_allclose(shown[1:-1, 1:-1], areas[1:-1, 1:-1], rtol=1e-6)
    part, _ = plane.window(slice(10, 30), slice(-20, None))
    assert_allclose(part, points[10:30, -20:], atol=1e-12)


@pytest.mark.parametrize("height", [240, 2800])
def test_marks_are_found_however_many_pixels_they_have(height: int) -> None:
    """Drawn by hand: such a large image of the renderer would take long."""
    per_m, middle = height / 2.3, np.array([height * 2 / 3, height / 2])
    pixels = np.full((height, height * 4 // 3, 3), 190, dtype=np.uint8)
    places = middle + MARKS.centers * (per_m, -per_m)
    for column, row in places.round().astype(int).tolist():
        cv2.circle(pixels, (column, row), round(MARKS.radius * per_m), (30, 30, 30), -1)

    found = find_marks(pixels)

    assert found is not None
    assert_allclose(found, places, atol=0.6)  # they were drawn around whole pixels


def test_a_mark_of_few_pixels_beside_the_grid_of_the_image_is_found() -> None:
    coarse = camera(seed=9, width_px=320, height_px=240)
    shot = coarse.take(0, 0.0, STARTS, YAWS)

    assert shot is not None
    found = find_marks(shot.pixels)
    assert found is not None
    assert_allclose(found, coarse.optics.project(FLOOR), atol=0.3)


def test_pixel_areas_add_up_to_the_area_of_what_they_show() -> None:
    optics = camera().optics
    place = calibrate(optics.project(FLOOR), optics.info, MARKS)
    assert place is not None

    points, areas = plane_maps(place, [0.12])[0.12].window(EVERYWHERE, EVERYWHERE)

    inside = (np.abs(points) <= 0.9).all(axis=2)
    assert areas[inside].sum() == pytest.approx(1.8**2, rel=0.005)
