"""Where a camera is and how its lens bends light: from points to pixels, and from pixels to points of a plane.

A pinhole with the radial and tangential distortion of Brown (1966), in the convention of ``sensor_msgs/CameraInfo``,
model ``plumb_bob``. The mission computer undistorts with OpenCV; this is written independently, so that an error in one
of them shows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.messages.camera import CameraInfo
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import CameraConfig

UNDISTORT_ROUNDS, UNDISTORTED = 60, 1e-10
"""Most rounds of the fixed-point iteration, and the error of a direction at which it ends; 1e-10 is 1e-7 of a pixel."""
K2_SHARE = -1.0 / 40.0
TANGENTIAL = (4e-4, -3e-4)
"""Distortion beyond k1: k2 as a share of it, and p1, p2 of a lens that sits a little askew."""


@dataclass(frozen=True, slots=True, eq=False)
class Optics:
    """A camera at its place.

    Attributes
    ----------
    info : CameraInfo
    rotation : (3, 3) array
        Turns world vectors into the camera frame.
    position : (3,) array
        Of the pinhole, world frame [m].
    """

    info: CameraInfo
    rotation: FloatArray
    position: FloatArray

    def project(self, points: FloatArray) -> FloatArray:
        """Return the pixels (n, 2) in which world points (n, 3) [m] appear; column first."""
        seen = (points - self.position) @ self.rotation.T
        bent = self._distort(seen[:, :2] / seen[:, 2:])
        fx, fy, center = self._scales()
        return bent * (fx, fy) + center

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Return the directions (..., 3), world frame, in which pixels (..., 2) look; downward component -1 or so."""
        fx, fy, center = self._scales()
        bent = (pixels - center) / (fx, fy)
        straight = bent.copy()
        for _ in range(UNDISTORT_ROUNDS):
            missing = bent - self._distort(straight)
            straight = straight + missing
            if np.abs(missing).max() < UNDISTORTED:
                break
        rays: FloatArray = np.concatenate([straight, np.ones_like(straight[..., :1])], axis=-1) @ self.rotation
        return rays

    def plane_points(self, rays: FloatArray, height: float) -> FloatArray:
        """Return where rays (..., 3) meet the plane at a height [m], as points (..., 2) [m]."""
        along = (height - self.position[2]) / rays[..., 2:]
        points: FloatArray = self.position[:2] + along * rays[..., :2]
        return points

    def _scales(self) -> tuple[float, float, FloatArray]:
        matrix = self.info.intrinsics
        return float(matrix[0, 0]), float(matrix[1, 1]), matrix[:2, 2]

    def _distort(self, straight: FloatArray) -> FloatArray:
        k1, k2, p1, p2, k3 = self.info.distortion
        x, y = straight[..., 0], straight[..., 1]
        square = x * x + y * y
        radial = 1.0 + square * (k1 + square * (k2 + square * k3))
        return np.stack(
            [
                x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
                y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
            ],
            axis=-1,
        )


def make_optics(config: CameraConfig, rng: np.random.Generator) -> Optics:
    """Return a camera above the origin that looks down, mounted as well as people mount cameras.

    Parameters
    ----------
    config : CameraConfig
    rng : Generator
        Draws place, aim and roll.
    """
    position = np.array([0.0, 0.0, config.elevation_m]) + config.mount_sigma_m * rng.normal(size=3)
    aim = np.append(config.aim_sigma_m * rng.normal(size=2), 0.0)
    roll = config.roll_sigma_rad * float(rng.normal())
    focal = config.height_px * config.elevation_m / config.view_m
    center = (config.width_px - 1) / 2.0, (config.height_px - 1) / 2.0
    intrinsics = np.array([[focal, 0.0, center[0]], [0.0, focal, center[1]], [0.0, 0.0, 1.0]])
    k1 = config.radial_distortion
    lens = (k1, K2_SHARE * k1, *TANGENTIAL, 0.0) if not math.isclose(k1, 0.0) else (0.0,) * 5
    info = CameraInfo(config.width_px, config.height_px, intrinsics, np.array(lens))
    return Optics(info, _looking_along(aim - position, roll), position)


def stated_info(true: CameraInfo, sigma: float, rng: np.random.Generator) -> CameraInfo:
    """Return what the maker of a camera says of it, who measured it with a relative error of about `sigma`.

    Focal lengths are off by that share, the optical center by that share of the focal length, and the coefficients of
    the lens, which are far harder to measure, by ten times as much.
    """
    intrinsics = true.intrinsics.copy()
    focal = float(intrinsics[0, 0])
    intrinsics[0, 0] *= 1.0 + sigma * float(rng.normal())
    intrinsics[1, 1] *= 1.0 + sigma * float(rng.normal())
    intrinsics[:2, 2] += sigma * focal * rng.normal(size=2)
    distortion = true.distortion * (1.0 + 10.0 * sigma * rng.normal(size=true.distortion.shape))
    return CameraInfo(true.width, true.height, intrinsics, distortion)


def _looking_along(view: FloatArray, roll: float) -> FloatArray:
    """Return the rotation of a camera that looks along `view` (3,), its right side along +x but for a roll [rad]."""
    ahead = view / np.linalg.norm(view)
    down = np.array([-np.sin(roll), -np.cos(roll), 0.0])
    right = np.cross(down, ahead)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(ahead, right), ahead])
