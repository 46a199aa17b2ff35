"""What a camera has in view: what the lens lets through to the image, and what the image then shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.types import BoolArray, FloatArray
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.overhead_camera import mounted_optics
from swarm_sim.config import CameraConfig

VIEW_MARGIN_PX = 1.0
"""A cover that comes nearer to the border than this is not wholly in view."""
CORNERS = 48
"""Points of the rim of a disc that are looked at."""
LENS_SAMPLES, LENS_REACH = 2000, 4.0
"""Radii at which the lens is tried, out to so many times the radius of the image's corner."""


def lens_limit(optics: Optics) -> float | None:
    """Return how far from its axis a lens still sees the image's corner, as the tangent of the angle.

    Within that, points that are farther out appear farther out; beyond, Brown's polynomial turns back, and what is far
    away is folded into the image. None: the lens turns back before the corner.
    """
    info = optics.info
    size, center = np.array([info.width - 1, info.height - 1]), info.intrinsics[:2, 2]
    scale = np.diag(info.intrinsics)[:2]
    corner = float(np.hypot(*(np.maximum(center, size - center) / scale)))
    k1, k2, _, _, k3 = info.distortion.tolist()
    radii = np.linspace(0.0, LENS_REACH * corner, LENS_SAMPLES)
    square = radii**2
    bent = radii * (1.0 + square * (k1 + square * (k2 + square * k3)))
    turns = np.flatnonzero(np.diff(bent) <= 0.0)
    seen = np.flatnonzero(bent[: turns[0] + 1 if len(turns) else None] >= corner)
    return float(radii[seen[0]]) if len(seen) else None


def rim_pixels(optics: Optics, limit: float, center: FloatArray, radius: float, height: float) -> FloatArray | None:
    """Return the pixels (c, 2) of the rim of a horizontal disc, None if it is beyond what the lens shows.

    Parameters
    ----------
    optics : Optics
    limit : float
        How far from its axis the lens sees; see `lens_limit`.
    center : (2,) array
        [m].
    radius, height : float
        [m].
    """
    angles = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
    rim = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(CORNERS)])
    points = radius * rim + np.array([center[0], center[1], height])
    seen = (points - optics.position) @ optics.rotation.T
    if (seen[:, 2] <= 0.0).any() or (np.hypot(seen[:, 0], seen[:, 1]) > limit * seen[:, 2]).any():
        return None
    return optics.project(points)


class Sight:
    """Whom the images of a run show, known from the truth; for metrics alone.

    Parameters
    ----------
    config : CameraConfig
    markers : sequence of CoverMarker
        One per robot, in their order.
    seed : int
        Of the run.
    """

    def __init__(self, config: CameraConfig, markers: Sequence[CoverMarker], seed: int) -> None:
        self._config, self._markers = config, tuple(markers)
        self._optics = mounted_optics(config, seed)
        self._limit = lens_limit(self._optics) or 0.0  # of a lens that is not sound: it sees nobody

    def in_view(self, time: float, positions: FloatArray) -> BoolArray:
        """Return whose whole cover (n,) an image shows that is taken at `time` [s] of robots at positions (n, 2) [m].

        The part of an image that is black as the scenario says shows nobody.
        """
        config, info = self._config, self._optics.info
        is_half_black = config.black_from_s <= time < config.black_from_s + config.black_for_s
        low = np.array([info.width // 2 if is_half_black else 0, 0]) + VIEW_MARGIN_PX
        high = np.array([info.width, info.height]) - 1.0 - VIEW_MARGIN_PX
        shown = np.zeros(len(self._markers), dtype=bool)
        for row, marker in enumerate(self._markers):
            pixels = rim_pixels(self._optics, self._limit, positions[row], marker.radius, marker.height)
            shown[row] = pixels is not None and bool(((pixels >= low) & (pixels <= high)).all())
        return shown
