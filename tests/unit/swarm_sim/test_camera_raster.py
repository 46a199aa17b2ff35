from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from table_top import AWAY, GREEN, MARKERS, RED, STARTS, YAWS, camera, moved

from swarm_msgs_py.light import linear_of
from swarm_msgs_py.markers import PRINTED_SRGB
from swarm_sim.camera.coverage import edge_coverage
from swarm_sim.camera.exposure import codes_of, digitize, illumination
from swarm_sim.config import CameraConfig

SUB = 24  # samples per pixel and axis of the reference


def sampled(field: np.ndarray, size: int) -> np.ndarray:
    """Return the share of negative samples in each pixel of a field with SUB samples per pixel."""
    return (field < 0.0).reshape(size, SUB, size, SUB).mean(axis=(1, 3))


def grid(size: int, per_pixel: int) -> tuple[np.ndarray, np.ndarray]:
    step = (np.arange(size * per_pixel) + 0.5) / per_pixel - 0.5
    return np.meshgrid(step, step)


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4.0, 1.2, 2.5])
def test_coverage_of_a_straight_edge_is_exact(angle: float) -> None:
    def distance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return (x - 4.2) * np.cos(angle) + (y - 4.7) * np.sin(angle)

    covered = edge_coverage(distance(*grid(10, 1)).astype(np.float32))

    assert_allclose(covered, sampled(distance(*grid(10, SUB)), 10), atol=0.025)  # 1 / SUB of sampling, on average half


@pytest.mark.parametrize("center", [(9.0, 9.0), (9.3, 8.6)])
def test_coverage_of_a_disc_is_right_to_a_percent_of_a_pixel(center: tuple[float, float]) -> None:
    def distance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.hypot(x - center[0], y - center[1]) - 4.0

    covered = edge_coverage(distance(*grid(19, 1)).astype(np.float32)).astype(np.float64)
    x, y = grid(19, 1)

    assert_allclose(covered, sampled(distance(*grid(19, SUB)), 19), atol=0.05)
    assert covered.sum() == pytest.approx(np.pi * 16.0, rel=0.01)
    assert_allclose([(covered * x).sum(), (covered * y).sum()] / covered.sum(), center, atol=2e-3)


def test_a_wider_spot_softens_the_edge_and_keeps_the_area() -> None:
    x, y = grid(19, 1)
    distances = (np.hypot(x - 9.2, y - 9.0) - 5.0).astype(np.float32)

    sharp, soft = edge_coverage(distances), edge_coverage(distances, 2.0)

    assert ((soft > 0.01) & (soft < 0.99)).sum() > 1.5 * ((sharp > 0.01) & (sharp < 0.99)).sum()
    assert soft.sum() == pytest.approx(sharp.sum(), rel=0.02)


def test_codes_and_light_are_inverse() -> None:
    for srgb in PRINTED_SRGB.values():
        assert_allclose(codes_of(linear_of(srgb).astype(np.float32)), srgb, atol=0.6)


def test_noise_has_the_configured_size() -> None:
    flat = np.full((100, 120, 3), 128.0, dtype=np.float32)

    noisy = digitize(flat, 3.0, np.random.default_rng(0)).astype(float)

    assert noisy.mean() == pytest.approx(128.0, abs=0.1)
    assert noisy.std() == pytest.approx(np.hypot(3.0, 12.0**-0.5), rel=0.03)
    assert_array_equal(digitize(flat, 0.0, np.random.default_rng(0)), 128)


def test_light_falls_off_from_one_side_to_the_other_and_to_the_corners() -> None:
    config = CameraConfig(light_gradient=0.4, vignette=0.2, tint_sigma=0.0)

    light = illumination(config, np.random.default_rng(3))

    assert light[239:241, 319:321].mean() == pytest.approx(1.0, abs=0.01)
    assert light.min() < 0.65
    assert light.max() > 1.15
    assert_array_equal(light[:, :, 0], light[:, :, 2])


@pytest.mark.parametrize(("width", "height"), [(640, 480), (480, 640), (500, 500)])
def test_the_vignette_is_what_the_corners_lose(width: int, height: int) -> None:
    config = CameraConfig(light_gradient=0.0, vignette=0.2, tint_sigma=0.0, width_px=width, height_px=height)

    light = illumination(config, np.random.default_rng(3))

    assert light[0, 0, 0] == pytest.approx(0.8, abs=0.002)


def test_covers_appear_where_the_optics_say_in_the_colors_of_the_robots() -> None:
    shot = camera(noise_codes=0.0, light_gradient=0.0, vignette=0.0, tint_sigma=0.0)
    pixels = shot.take(0, 0.0, STARTS, YAWS).pixels  # type: ignore[union-attr]

    for marker, place, yaw in zip(MARKERS, STARTS, YAWS, strict=True):
        ahead = np.array([np.cos(yaw), np.sin(yaw)])
        for offset in (marker.large_place, marker.small_place):
            column, row = shot.optics.project(np.array([[*(place + offset * ahead), marker.height]]))[0]
            assert_allclose(pixels[round(row), round(column)], PRINTED_SRGB[marker.color], atol=2)


def test_an_image_is_the_same_again_and_another_number_has_other_noise() -> None:
    shots = [camera().take(number, 0.0, STARTS, YAWS).pixels for number in (3, 4, 3)]  # type: ignore[union-attr]

    assert_array_equal(shots[0], shots[2])
    assert (shots[0] != shots[1]).mean() > 0.3


def test_moving_one_robot_changes_nothing_elsewhere() -> None:
    before = camera().take(0, 0.0, STARTS, YAWS).pixels  # type: ignore[union-attr]
    after = camera().take(0, 0.0, moved(RED, AWAY), YAWS).pixels  # type: ignore[union-attr]

    rows, columns = np.nonzero((before != after).any(axis=2))
    place = camera().optics.project(np.array([[*STARTS[RED], 0.06]]))[0]

    assert len(rows) > 1000
    assert np.hypot(columns - place[0], rows - place[1]).max() < 60.0  # 16 cm and the parallax of 12 cm


def test_a_robot_half_out_of_view_is_cut_by_the_border() -> None:
    shot = camera().take(0, 0.0, moved(GREEN, (1.42, 0.0)), np.zeros(5))

    assert shot is not None
    assert shot.pixels.shape == (480, 640, 3)
    row = round(camera().optics.project(np.array([[1.3, 0.0, 0.12]]))[0][1])
    assert shot.pixels[row, -1].max() < 90  # its black cover ends with the image


def test_the_camera_fails_when_told() -> None:
    shot = camera(off_from_s=5.0, off_for_s=2.0, black_from_s=10.0, black_for_s=1.0)

    assert [shot.take(0, time, STARTS, YAWS) is None for time in (4.9, 5.0, 6.9, 7.0)] == [False, True, True, False]
    black, whole = (shot.take(0, time, STARTS, YAWS).pixels for time in (10.5, 11.0))  # type: ignore[union-attr]
    assert black[:, :320].max() == 0
    assert_array_equal(black[:, 320:], whole[:, 320:])


def test_images_come_at_the_configured_rate() -> None:
    shot = camera(rate_hz=10.0)

    assert shot.is_due(0.0, None)
    assert not shot.is_due(0.05, 0.0)
    assert shot.is_due(0.1, 0.0)
    assert shot.is_due(3 * 0.1, 2 * 0.1)  # in spite of rounding
