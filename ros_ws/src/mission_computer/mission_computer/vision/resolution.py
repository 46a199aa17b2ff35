"""What follows from the number of pixels: sizes given for one resolution, and what is too coarse to be read."""

from __future__ import annotations

from collections.abc import Iterable

from swarm_msgs_py.markers import CoverMarker
from swarm_msgs_py.messages.camera import CameraInfo

REFERENCE_ROWS = 480
"""Height of the images for which numbers of pixels are given; in others they grow with the image."""
FINE_RADIUS_PX = 3.6
"""From this radius on, what is measured of the form of a disc is as good as tolerances ask for [pixels]."""
LEAST_RADIUS_PX = 1.8
"""Discs of a smaller radius cannot be told from noise [pixels]."""


def scale_of(rows: int) -> float:
    """Return how much finer an image of so many rows is than that for which numbers of pixels are given."""
    return rows / REFERENCE_ROWS


def coarseness(radius_px: float) -> float:
    """Return by how much errors of a disc of that radius [pixels] exceed those of a large one: 1 or more."""
    return max(FINE_RADIUS_PX / radius_px, 1.0)


def smallest_radius_px(markers: Iterable[CoverMarker], info: CameraInfo, elevation_m: float) -> float:
    """Return the radius of the smallest disc as a camera sees it from above [pixels]; see `LEAST_RADIUS_PX`.

    Parameters
    ----------
    markers : iterable of CoverMarker
        At least one.
    info : CameraInfo
    elevation_m : float
        Of the camera above the floor [m].
    """
    focal = min(float(info.intrinsics[0, 0]), float(info.intrinsics[1, 1]))
    return min(focal * marker.small_radius / (elevation_m - marker.height) for marker in markers)
