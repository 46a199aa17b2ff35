"""What a camera delivers: an image, and how its pixels map to directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.types import FloatArray

ImageArray = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class CameraInfo:
    """Geometry of a camera, as its maker measured it (``sensor_msgs/CameraInfo``, model ``plumb_bob``).

    Attributes
    ----------
    width, height : int
        [pixels].
    intrinsics : (3, 3) array
        ``[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]`` [pixels]; the middle of the first pixel is at (0, 0).
    distortion : (5,) array
        Radial k1, k2, tangential p1, p2, radial k3.
    """

    width: int
    height: int
    intrinsics: FloatArray
    distortion: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CameraImage:
    """One picture (``sensor_msgs/Image``, encoding ``rgb8``).

    Attributes
    ----------
    time : float
        When it was taken, simulated time [s].
    pixels : (height, width, 3) uint8 array
        Red, green, blue; rows from the top.
    """

    time: float
    pixels: ImageArray
