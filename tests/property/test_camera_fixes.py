"""What the camera localization must hold for any pose and any light."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from table_top import BLUE, MARKERS, camera, localizer, moved, picture

from mission_computer.vision.colors import hue_and_saturation
from mission_computer.vision.config import HUE_TOLERANCE_MAX_RAD, VisionConfig
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.light import linear_of
from swarm_msgs_py.markers import PRINTED_SRGB, MarkerColor
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.messages.camera_report import CameraStatus
from swarm_sim.camera.exposure import codes_of

EYES = localizer(reach_m=1e3)
assert EYES.locate(picture(), camera().info).status is CameraStatus.OK
PLACES = st.tuples(st.floats(-0.4, 0.35), st.floats(-0.3, 0.5))  # free of the other robots


@settings(max_examples=15, deadline=None, derandomize=True)
@given(place=PLACES, yaw=st.floats(-3.14, 3.14))
def test_a_robot_is_found_wherever_it_is_and_however_it_is_turned(place: tuple[float, float], yaw: float) -> None:
    positions, yaws = moved(BLUE, place), np.zeros(5)
    yaws[BLUE] = yaw

    report = EYES.locate(picture(positions, yaws), camera().info)

    assert len(report.fixes) == 5
    fix = report.fixes[BLUE]
    assert_allclose(fix.position, place, atol=2e-3)
    assert abs((fix.yaw - yaw + np.pi) % (2.0 * np.pi) - np.pi) < np.deg2rad(0.5)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(color=st.sampled_from(MarkerColor), light=st.floats(0.25, 1.1), covered=st.floats(0.4, 1.0))
def test_hue_and_saturation_depend_neither_on_the_light_nor_on_how_much_of_a_pixel_is_covered(
    color: MarkerColor, light: float, covered: float
) -> None:
    dimmed = codes_of((light * covered * linear_of(PRINTED_SRGB[color])).astype(np.float32))
    codes = np.array([PRINTED_SRGB[color], np.rint(dimmed)]).astype(np.uint8)

    hues, saturations = hue_and_saturation(codes)

    # Codes are whole numbers, and the lightness of CIELAB has an offset of 16: both move dark colors a little.
    assert abs((hues[1] - hues[0] + np.pi) % (2.0 * np.pi) - np.pi) < 0.19  # half of the tolerance
    assert saturations[1] > 0.9 * saturations[0] > 0.4


@settings(max_examples=20, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 30), noise=st.sampled_from([0, 20]))
@example(seed=0, count=0, noise=255)
def test_scribble_is_no_robot_and_does_no_harm(seed: int, count: int, noise: int) -> None:
    """Lines, boxes, and single pixels of all colors, also at the very edges of the image."""
    rng = np.random.default_rng(seed)
    pixels = rng.integers(0, noise, (480, 640, 3), dtype=np.uint8, endpoint=True)
    for _ in range(count):
        row, column, high, wide = rng.integers((0, 0, 1, 1), (480, 640, 40, 60))
        high, wide = ((high, 1), (1, wide), (high, wide))[rng.integers(3)]
        pixels[row : row + high, column : column + wide] = rng.integers(0, 256, 3)

    report = EYES.locate(CameraImage(0.0, pixels), camera().info)

    assert report.fixes == ()
    assert all(np.isfinite(stray.position).all() for stray in report.strays)


def test_all_robots_have_hues_that_lie_farther_apart_than_the_tolerances_reach() -> None:
    hues, _ = hue_and_saturation(np.array([PRINTED_SRGB[marker.color] for marker in MARKERS], dtype=np.uint8))

    gaps = np.diff(np.sort(hues), append=np.sort(hues)[0] + 2.0 * np.pi)
    assert gaps.min() > 2.0 * HUE_TOLERANCE_MAX_RAD >= 2.0 * VisionConfig().hue_tolerance_rad


def test_a_tolerance_at_which_colors_would_overlap_is_refused() -> None:
    with pytest.raises(ConfigError, match="hue_tolerance_rad"):
        VisionConfig(hue_tolerance_rad=0.43)
