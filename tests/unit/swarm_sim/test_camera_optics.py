from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from swarm_msgs_py.markers import FloorMarks
from swarm_sim.camera.optics import Optics, make_optics, stated_info
from swarm_sim.config import CameraConfig

PIXELS = np.array([(0.0, 0.0), (639.0, 0.0), (320.0, 240.0), (100.5, 400.25), (639.0, 479.0)])


def make(seed: int = 1, **changes: float) -> Optics:
    return make_optics(CameraConfig(**changes), np.random.default_rng(seed))


@pytest.mark.parametrize("k1", [-0.15, -0.06, 0.0, 0.15])
@pytest.mark.parametrize("height", [0.0, 0.12])
def test_a_pixel_shows_the_point_that_is_projected_into_it(k1: float, height: float) -> None:
    optics = make(radial_distortion=k1)

    points = optics.plane_points(optics.rays(PIXELS), height)
    pixels = optics.project(np.column_stack([points, np.full(len(points), height)]))

    assert_allclose(pixels, PIXELS, atol=1e-6)


def test_a_perfectly_mounted_pinhole_scales_by_height_over_distance() -> None:
    optics = make(radial_distortion=0.0, mount_sigma_m=0.0, aim_sigma_m=0.0, roll_sigma_rad=0.0)
    focal = 480.0 * 2.4 / 2.3

    pixels = optics.project(np.array([(0.0, 0.0, 0.0), (0.5, 0.25, 0.0), (0.5, 0.25, 0.12)]))

    expected = [
        (319.5, 239.5),
        (319.5 + focal * 0.5 / 2.4, 239.5 - focal * 0.25 / 2.4),  # y grows upwards on the map, downwards in the image
        (319.5 + focal * 0.5 / 2.28, 239.5 - focal * 0.25 / 2.28),
    ]
    assert_allclose(pixels, expected, atol=1e-9)


def test_a_lens_with_negative_k1_pulls_the_corners_in() -> None:
    corner = np.array([(1.0, 1.0, 0.0)])
    straight, bent = (
        make(radial_distortion=k1, mount_sigma_m=0.0, aim_sigma_m=0.0, roll_sigma_rad=0.0).project(corner)[0]
        for k1 in (0.0, -0.1)
    )

    assert np.hypot(*(bent - (319.5, 239.5))) < np.hypot(*(straight - (319.5, 239.5))) - 5.0


@pytest.mark.parametrize("seed", range(20))
def test_however_it_is_mounted_it_sees_all_floor_marks(seed: int) -> None:
    marks = FloorMarks()
    around = marks.centers[:, None] + marks.radius * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
    optics = make(seed)

    pixels = optics.project(np.column_stack([around.reshape(-1, 2), np.zeros(16)]))

    assert ((pixels >= 1.0) & (pixels <= (638.0, 478.0))).all()


def test_what_the_maker_says_is_nearly_true() -> None:
    true = make().info

    stated = stated_info(true, 0.001, np.random.default_rng(0))

    assert_allclose(stated.intrinsics, true.intrinsics, rtol=0.01)
    assert abs(stated.intrinsics[0, 0] / true.intrinsics[0, 0] - 1.0) > 1e-5
    assert_allclose(stated.distortion, true.distortion, rtol=0.05)
