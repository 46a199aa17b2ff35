"""The five robots of the table-top arena, and a camera above them, as the tests of camera and vision need them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from mission_computer.vision.camera_localizer import CameraLocalizer
from mission_computer.vision.config import VisionConfig
from swarm_msgs_py.markers import CoverMarker, FloorMarks, MarkerColor
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.camera.overhead_camera import OverheadCamera
from swarm_sim.camera.raster import Spot
from swarm_sim.config import CameraConfig

RED, BLUE, GREEN, YELLOW, PINK = range(5)
MARKERS = tuple(
    CoverMarker(robot=NodeId(number), color=color, radius=radius)
    for number, (color, radius) in enumerate(zip(MarkerColor, (0.16, 0.11, 0.11, 0.08, 0.08), strict=True))
)
STARTS = np.array([(-0.62, -0.72), (-0.82, 0.3), (0.8, -0.3), (-0.15, 0.86), (0.55, 0.8)])
YAWS = np.array([0.3, -2.0, 1.2, 2.9, -0.7])
AWAY = (30.0, 30.0)


@cache
def camera(seed: int = 5, **changes: Any) -> OverheadCamera:
    """Return a camera; the same object for the same arguments, since cameras have no state and are slow to make."""
    return OverheadCamera(CameraConfig(is_on=True, **changes), MARKERS, FloorMarks(), seed)


def picture(positions: FloatArray = STARTS, yaws: FloatArray = YAWS, *spots: Spot, number: int = 0) -> CameraImage:
    """Return an image of robots, and spots on the floor, that may be written to."""
    image = camera().take(number, 0.1 * number, positions, yaws, spots)
    assert image is not None
    return image


def moved(robot: int, to: tuple[float, float]) -> FloatArray:
    """Return the start positions with one robot elsewhere."""
    positions = STARTS.copy()
    positions[robot] = to
    return positions


def localizer(**changes: Any) -> CameraLocalizer:
    """Return a localizer that is content with one image for its calibration."""
    return CameraLocalizer(replace(VisionConfig(calibration_frames=1), **changes), MARKERS, FloorMarks())
