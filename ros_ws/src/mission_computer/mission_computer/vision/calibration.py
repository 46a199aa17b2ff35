"""Where the camera is, from the four marks on the floor, and which point of the arena each pixel shows.

The marks' middles are measured to a few hundredths of a pixel; the pose that explains them best is found with OpenCV
(IPPE of Collins and Bartoli, 2014, for a plane, then Levenberg-Marquardt). Lens distortion is undone once per
calibration instead of once per image, at few points: between them, a pixel's point on a plane is a polynomial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from mission_computer.vision.resolution import scale_of
from swarm_msgs_py.light import light_of
from swarm_msgs_py.markers import FloorMarks
from swarm_msgs_py.messages.camera import CameraInfo, ImageArray
from swarm_msgs_py.types import FloatArray

MARK_AREA_PX = (20, 4000)
"""Smallest and largest mark [pixels of an image of REFERENCE_ROWS]; covers of robots are larger."""
MARK_AREA_LEAST_PX = 12
"""The form of fewer pixels than these says nothing, however coarse the image."""
MARK_ASPECT = 1.35
"""Largest ratio of the sides of a mark's bounding box."""
MARK_FILL = (0.65, 0.92)
"""Share of its bounding box that a disc fills: pi / 4, give or take pixels."""
COARSE_ASPECT, COARSE_FILL = 0.15, -0.1
"""By how much the bounds of aspect and least fill move where pixels are twice as large: they are of boxes of pixels."""
MARK_SPREAD = 1.6
"""Largest ratio of the areas of two marks: they are equal, and the camera looks down."""
MARK_MARGIN_PX, MARK_MARGIN_LEAST_PX = 4, 2
"""Free pixels around a mark: of an image of REFERENCE_ROWS, and at least."""
MARK_CONTRAST_CODES = 30
"""How much darker than its surroundings a pixel of a mark is, at least [codes of 255]."""
NEIGHBORHOOD_SHARE = 8
"""The surroundings are a square with this part of the image's height as its side: several times a mark."""
NODES = 24
"""Points per axis from which maps are interpolated; a lens without kinks then differs by less than 1e-9 m."""
UNDISTORT_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 60, 1e-10)


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A camera whose place is known.

    Attributes
    ----------
    info : CameraInfo
    rotation : (3, 3) array
        Turns world vectors into the camera frame.
    translation : (3,) array
        World origin in the camera frame [m].
    error_px : float
        Largest distance of a floor mark from where it should appear [pixels].
    """

    info: CameraInfo
    rotation: FloatArray
    translation: FloatArray
    error_px: float

    def project(self, points: FloatArray) -> FloatArray:
        """Return the pixels (n, 2) in which world points (n, 3) [m] appear; column first."""
        vector, _ = cv2.Rodrigues(self.rotation)
        pixels, _ = cv2.projectPoints(points, vector, self.translation, self.info.intrinsics, self.info.distortion)
        return _floats(pixels).reshape(-1, 2)

    def rays(self, pixels: FloatArray) -> FloatArray:
        """Return the directions (n, 3), world frame, in which pixels (n, 2) look."""
        straight = cv2.undistortPoints(
            pixels.reshape(-1, 1, 2), self.info.intrinsics, self.info.distortion, criteria=UNDISTORT_CRITERIA
        ).reshape(-1, 2)
        rays: FloatArray = np.column_stack([straight, np.ones(len(straight))]) @ self.rotation
        return rays

    def plane_points(self, rays: FloatArray, height: float) -> FloatArray:
        """Return where rays (n, 3) meet the plane at a height [m], as points (n, 2) [m]."""
        position = -self.rotation.T @ self.translation
        along = (height - position[2]) / rays[:, 2:]
        points: FloatArray = position[:2] + along * rays[:, :2]
        return points


@dataclass(frozen=True, slots=True, eq=False)
class PlaneMap:
    """The point of a plane that each pixel shows: a polynomial through nodes, worked out where it is asked for.

    Attributes
    ----------
    nodes : (3, n, n) array
        At rows and columns of nodes: x and y [m], world frame, and the area of the plane that a pixel covers [m^2].
    down, across : (h, n) array, (w, n) array
        Weights of the nodes in each row and in each column of pixels.
    """

    nodes: FloatArray
    down: FloatArray
    across: FloatArray

    def window(self, rows: slice, columns: slice) -> tuple[FloatArray, FloatArray]:
        """Return points (h, w, 2) [m] and areas (h, w) [m^2] of the pixels of a part of the image."""
        down, across = self.down[rows], self.across[columns].T
        x, y, areas = (down @ values @ across for values in self.nodes)
        return np.stack([x, y], axis=-1), areas


def plane_maps(calibration: Calibration, heights: Sequence[float]) -> dict[float, PlaneMap]:
    """Return the maps of planes at several heights above the floor [m].

    To undo the lens pixel by pixel takes 60 ms. It bends smoothly, so the map is a polynomial through few points.
    """
    info = calibration.info
    (rows, down), (columns, across) = _nodes(info.height), _nodes(info.width)
    middle = np.stack(np.meshgrid(columns, rows), axis=-1)
    steps = np.array([(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)])  # a node, and one pixel from it on each side
    rays = calibration.rays((middle + steps[:, None, None]).reshape(-1, 2))
    maps = {}
    for height in sorted(set(heights)):
        here, left, right, up, low = calibration.plane_points(rays, height).reshape(len(steps), NODES, NODES, 2)
        per_column, per_row = (right - left) / 2.0, (low - up) / 2.0
        areas = np.abs(per_column[..., 0] * per_row[..., 1] - per_column[..., 1] * per_row[..., 0])
        maps[height] = PlaneMap(np.stack([here[..., 0], here[..., 1], areas]), down, across)
    return maps


def _nodes(size: int) -> tuple[FloatArray, FloatArray]:
    """Return the Chebyshev nodes (n,) of an axis of pixels, and the weights (size, n) of their values in each pixel."""
    nodes, half = chebyshev.chebpts1(NODES), (size - 1) / 2.0
    at_nodes = chebyshev.chebvander(nodes, NODES - 1)
    at_pixels = chebyshev.chebvander(np.arange(size) / half - 1.0, NODES - 1)
    return half * (1.0 + nodes), _floats(np.linalg.solve(at_nodes.T, at_pixels.T).T)


def find_marks(pixels: ImageArray) -> FloatArray | None:
    """Return the middles of the floor marks (4, 2) [pixels], or None if they do not show.

    The marks are the dark discs that are nearest to the corners of the image, in the order lower left, lower right,
    upper right, upper left: the upper edge of the image is +y, to within 45 degrees.
    """
    gray = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    # Compared with their own surroundings: in uneven light no one threshold parts floor and marks.
    window = gray.shape[0] // NEIGHBORHOOD_SHARE | 1
    dark = cv2.adaptiveThreshold(
        gray, 255, cv2.ADAPTIVE_THRESH_MEAN_C, cv2.THRESH_BINARY_INV, window, MARK_CONTRAST_CODES
    )
    _, labels, stats, middles = cv2.connectedComponentsWithStats(dark)
    height, width = gray.shape
    scale = scale_of(height)
    least, most = max(MARK_AREA_PX[0] * scale**2, MARK_AREA_LEAST_PX), MARK_AREA_PX[1] * scale**2
    margin, coarse = _margin(height), max(1.0 / scale - 1.0, 0.0)
    left, top, wide, high, area = (stats[:, column].astype(np.float64) for column in range(5))
    fill, aspect = area / (wide * high), np.maximum(wide / high, high / wide)
    is_mark = (
        ((area >= least) & (area <= most) & (aspect <= MARK_ASPECT + COARSE_ASPECT * coarse))
        & ((fill >= MARK_FILL[0] + COARSE_FILL * coarse) & (fill <= MARK_FILL[1]))
        & ((left >= margin) & (top >= margin))
        & ((left + wide <= width - margin) & (top + high <= height - margin))
    )
    candidates = np.flatnonzero(is_mark)
    if len(candidates) < 4:
        return None
    corners = np.array([(0, height), (width, height), (width, 0), (0, 0)], dtype=np.float64)
    apart = np.linalg.norm(middles[candidates][None] - corners[:, None], axis=2)
    chosen = candidates[apart.argmin(axis=1)]
    if len(set(chosen.tolist())) < 4 or area[chosen].max() > MARK_SPREAD * area[chosen].min():
        return None
    codes, parts = np.asarray(gray, dtype=np.uint8), np.asarray(labels, dtype=np.int32)
    return np.stack([_middle(codes, parts, row, stats[row]) for row in chosen.tolist()])


def _margin(rows: int) -> int:
    """Return how many pixels around a mark are looked at, in an image of so many rows."""
    return max(round(MARK_MARGIN_PX * scale_of(rows)), MARK_MARGIN_LEAST_PX)


def calibrate(marks_px: FloatArray, info: CameraInfo, marks: FloorMarks) -> Calibration | None:
    """Return the place of the camera from the middles of the floor marks (4, 2) [pixels].

    Returns
    -------
    Calibration or None
        None if no camera above the floor sees them so.
    """
    floor = np.column_stack([marks.centers, np.zeros(4)])
    found, vectors, shifts, _ = cv2.solvePnPGeneric(
        floor, marks_px, info.intrinsics, info.distortion, flags=cv2.SOLVEPNP_IPPE
    )
    best: Calibration | None = None
    for vector, shift in zip(vectors[:found], shifts[:found], strict=True):
        refined = cv2.solvePnPRefineLM(floor, marks_px, info.intrinsics, info.distortion, vector.copy(), shift.copy())
        rotation, _ = cv2.Rodrigues(refined[0])
        place = Calibration(info, _floats(rotation), _floats(refined[1]).ravel(), 0.0)
        error = float(np.linalg.norm(place.project(floor) - marks_px, axis=1).max())
        is_above = float((-place.rotation.T @ place.translation)[2]) > 0.0
        if is_above and (best is None or error < best.error_px):
            best = Calibration(info, place.rotation, place.translation, error)
    return best


def _floats(array: object) -> FloatArray:
    """Return what OpenCV gave back with the type that it has."""
    return np.asarray(array, dtype=np.float64)


def _middle(gray: NDArray[np.uint8], labels: NDArray[np.int32], mark: int, stats: NDArray[np.int32]) -> FloatArray:
    """Return the middle (2,) of a dark disc on a light floor: centroid of the light that it takes away [pixels].

    A robot's black cover may stand right beside the mark; the light that it takes away does not count.

    Parameters
    ----------
    gray : (h, w) uint8 array
    labels : (h, w) array
        Which dark part a pixel belongs to; 0 is the floor.
    mark : int
        Label of the disc.
    stats : (5,) array
        Left, top, width, height and area of the disc [pixels].
    """
    left, top, wide, high = stats[:4].tolist()
    margin = _margin(len(gray))
    rows, columns = np.mgrid[top - margin : top + high + margin, left - margin : left + wide + margin]
    light = light_of(gray[rows, columns])
    rim = np.concatenate([light[0], light[-1], light[:, 0], light[:, -1]])
    floor, core = float(np.median(rim)), float(np.percentile(light, 5.0))
    taken = np.clip((floor - light) / (floor - core), 0.0, 1.0)
    taken[taken < 0.1] = 0.0  # the grain of the floor is no part of the mark
    near = labels[rows, columns]
    others = ((near != 0) & (near != mark)).astype(np.uint8)
    taken[cv2.dilate(others, np.ones((3, 3), dtype=np.uint8)) > 0] = 0.0
    middle: FloatArray = np.array([(taken * columns).sum(), (taken * rows).sum()]) / float(taken.sum())
    return middle
