"""What every renderer of the camera must draw; one suite, run on each of them."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from table_top import GREEN, MARKERS, STARTS, YAWS, localizer

from mission_computer.vision.calibration import find_marks
from swarm_msgs_py.markers import FloorMarks, MarkerColor
from swarm_msgs_py.types import FloatArray
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.camera.raster import Spot
from swarm_sim.config import CameraConfig, Renderer

HAS_BULLET = importlib.util.find_spec("pybullet") is not None
RENDERERS = [
    Renderer.RASTER,
    pytest.param(Renderer.BULLET, marks=pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")),
]
FLOOR = np.column_stack([FloorMarks().centers, np.zeros(4)])


def make(renderer: Renderer, **changes: float) -> OverheadCamera:
    return OverheadCamera(CameraConfig(is_on=True, **changes), MARKERS, FloorMarks(), 5, renderer)


def draw(camera: OverheadCamera, *spots: Spot) -> FloatArray:
    image = camera.take(0, 0.0, STARTS, YAWS, spots)
    assert image is not None
    return image.pixels.astype(float)


@pytest.fixture(scope="module", params=RENDERERS, ids=lambda renderer: renderer.value)
def camera(request: pytest.FixtureRequest) -> Iterator[OverheadCamera]:
    made = make(request.param)
    yield made
    made.close()
    made.close()


def test_marks_appear_where_the_optics_say(camera: OverheadCamera) -> None:
    found = find_marks(draw(camera).astype(np.uint8))

    assert found is not None
    assert_allclose(found, camera.optics.project(FLOOR), atol=0.25)


def test_the_mission_computer_finds_all_robots_in_it(camera: OverheadCamera) -> None:
    image = camera.take(1, 0.0, STARTS, YAWS)
    assert image is not None

    report = localizer().locate(image, camera.info)

    assert len(report.fixes) == 5
    for fix in report.fixes:
        assert np.hypot(*(fix.position - STARTS[fix.robot])) < 0.0015
        assert abs(fix.yaw - YAWS[fix.robot]) < np.deg2rad(0.4)


def test_a_scene_is_drawn_the_same_again_also_after_another(camera: OverheadCamera) -> None:
    first = draw(camera)
    spotted = draw(camera, Spot(MarkerColor.PINK, (0.2, 0.1), 0.05))

    column, row = camera.optics.project(np.array([[0.2, 0.1, 0.0]]))[0].round().astype(int)
    assert spotted[row, column, 1] < first[row, column, 1] - 40.0
    assert_array_equal(draw(camera), first)


@pytest.mark.skipif(not HAS_BULLET, reason="pybullet is not installed")
def test_the_renderers_agree_on_covers_and_discs_and_their_edges() -> None:
    """Two independent pictures of one scene; PyBullet's has no grain on the floor."""
    cameras = [make(renderer, noise_codes=0.0, spot_px=1.0) for renderer in Renderer]
    one, other = (draw(camera) for camera in cameras)
    column, row = cameras[0].optics.project(np.array([[*STARTS[GREEN], 0.12]]))[0].round().astype(int)
    part = (slice(row - 24, row + 24), slice(column - 24, column + 24))
    for camera in cameras:
        camera.close()

    off = np.abs(one[part] - other[part]).max(axis=2)
    assert (off > 12.0).mean() < 0.03  # few pixels on edges, of which PyBullet takes four samples
    assert off.max() < 60.0
    assert np.median(off) < 4.0
