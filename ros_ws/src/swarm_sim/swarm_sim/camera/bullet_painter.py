"""The arena as PyBullet's software renderer draws it: meshes, seen by a perfect pinhole, bent by the lens afterwards.

TinyRenderer takes one sample per pixel, so a small disc is off by some percent in size and form: that is more than
the mission computer accepts of a cover. So what has edges is drawn with several samples per pixel and direction, and a
pixel of the camera takes the mean over the square that its lens spreads a point over. Only robots, spots and marks
have edges: a frame draws a window around each, and the bare floor between them was drawn once and for all. That takes
less time than whole images with one sample per pixel.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.light import light_of
from swarm_msgs_py.markers import PRINTED_SRGB, CoverMarker, FloorMarks
from swarm_msgs_py.types import FloatArray
from swarm_sim.bullet import open_server, pybullet
from swarm_sim.camera.exposure import LightArray, codes_of
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.raster import BLACK_SRGB, DRUM_SRGB, FLOOR_SRGB, Spot
from swarm_sim.camera.square_means import square_means
from swarm_sim.camera.windows import Window, window_around

SEGMENTS = 96
"""Corners of a disc: its area is off by less than 0.1 %."""
LAYER_M = 2e-4
"""What is printed on something lies this much above it [m], so that it hides it."""
SAMPLES = 2
"""Samples per pixel of the camera, along rows and along columns, where something has edges."""
NEAR_M, FAR_M = 0.3, 12.0
Mesh = tuple[list[list[float]], list[int]]
FLOOR: Mesh = [[-20.0, -10.0, 0.0], [20.0, -10.0, 0.0], [0.0, 30.0, 0.0]], [0, 1, 2]
"""One triangle that reaches farther than the camera sees."""
AWAY_M = 50.0
"""Where robots wait until they are drawn."""


class BulletPainter:
    """Draws the arena as seen through one camera, with PyBullet.

    Parameters
    ----------
    optics : Optics
    markers : sequence of CoverMarker
        One per robot, in the order in which poses are given.
    marks : FloorMarks
    light : (h, w, 3) float32 array
        Illumination of each pixel.
    spot_px : float
        Side of the square that the lens spreads a point over [pixels].

    Raises
    ------
    PhysicsError
        If the engine does not start.
    """

    def __init__(
        self,
        optics: Optics,
        markers: Sequence[CoverMarker],
        marks: FloorMarks,
        light: LightArray,
        spot_px: float = 1.0,
    ) -> None:
        self._optics, self._markers, self._light, self._spot_px = optics, tuple(markers), light, spot_px
        self._view, self._places = _view(optics), _places(optics)
        self._client = open_server()
        # What hides other things comes first: then those need no color.
        self._robots = [self._add_robot(marker) for marker in markers]
        for x, y in marks.centers.tolist():
            self._add(_disc(x, y, LAYER_M, marks.radius), BLACK_SRGB)
        self._add(FLOOR, FLOOR_SRGB)
        self._place(np.full((len(markers), 2), AWAY_M), np.zeros(len(markers)))
        everywhere = slice(0, optics.info.height), slice(0, optics.info.width)
        self._floor_codes = np.empty_like(light)
        self._draw([everywhere], self._floor_codes, samples=1)
        circles = [(center, marks.radius, 0.0) for center in marks.centers]
        self._draw(self._windows(circles), self._floor_codes)

    def draw(self, positions: FloatArray, yaws: FloatArray, spots: Sequence[Spot] = ()) -> LightArray:
        """Return the codes (h, w, 3) of robots at positions (n, 2) [m] with headings (n,) [rad]; see `Raster.draw`."""
        self._place(positions, yaws)
        lying = [self._add(_disc(*spot.center, LAYER_M, spot.radius), PRINTED_SRGB[spot.color]) for spot in spots]
        circles = [(np.array(spot.center), spot.radius, 0.0) for spot in spots]
        circles += [
            (place, marker.radius, marker.height) for marker, place in zip(self._markers, positions, strict=True)
        ]
        codes = self._floor_codes.copy()
        self._draw(self._windows(circles), codes)
        for body in lying:
            pybullet.removeBody(body, physicsClientId=self._client)
        return codes

    def _place(self, positions: FloatArray, yaws: FloatArray) -> None:
        """Put the robots at positions (n, 2) [m] with headings (n,) [rad]."""
        for parts, (x, y), yaw in zip(self._robots, positions.tolist(), yaws.tolist(), strict=True):
            turned = (0.0, 0.0, float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0)))
            for part in parts:
                pybullet.resetBasePositionAndOrientation(part, (x, y, 0.0), turned, physicsClientId=self._client)

    def _windows(self, circles: Iterable[tuple[FloatArray, float, float]]) -> list[Window]:
        """Return what of the image shows cylinders on the floor, by (center, radius, height) [m]."""
        windows = []
        for center, radius, height in circles:
            window = window_around(self._optics, center, radius, (0.0, height))
            if window is not None:
                windows.append(window)
        return windows

    def _draw(self, windows: Iterable[Window], codes: LightArray, samples: int = SAMPLES) -> None:
        """Draw parts of the image into `codes`, in place."""
        side = self._spot_px * samples
        for window in windows:
            places = samples * self._places[window]
            low = np.floor(places.min(axis=(0, 1)) - side).astype(int)
            high = np.ceil(places.max(axis=(0, 1)) + side).astype(int) + 1
            drawn = self._rendered(low, high, samples)
            # TinyRenderer asks what lies at the lower left corner of a pixel: that is the middle of what it stands for.
            across, down = places[..., 0] - low[0] + 0.5, places[..., 1] - low[1] - 0.5
            codes[window] = codes_of(square_means(drawn, across, down, side) * self._light[window])

    def _rendered(self, low: NDArray[np.intp], high: NDArray[np.intp], samples: int) -> LightArray:
        """Return the light of a part of what the pinhole sees, between corners (column, row) relative to its axis."""
        width, height = (high - low).tolist()
        _, _, pixels, _, _ = pybullet.getCameraImage(
            width,
            height,
            self._view,
            _projection(samples * float(self._optics.info.intrinsics[0, 0]), low, high),
            shadow=0,
            lightAmbientCoeff=1.0,  # colors as printed: light and its gradient come afterwards
            lightDiffuseCoeff=0.0,
            lightSpecularCoeff=0.0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        return light_of(np.asarray(pixels, dtype=np.uint8).reshape(height, width, -1)[:, :, :3])

    def close(self) -> None:
        """Stop the server; may be called again."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def _add_robot(self, marker: CoverMarker) -> list[int]:
        """Return the bodies that a robot consists of: drum, cover and two discs."""
        top, ink = marker.height, PRINTED_SRGB[marker.color]
        return [
            self._add(_disc(marker.large_place, 0.0, top, marker.large_radius), ink),
            self._add(_disc(marker.small_place, 0.0, top, marker.small_radius), ink),
            self._add(_disc(0.0, 0.0, top - LAYER_M, marker.radius), BLACK_SRGB),
            self._add(_drum(top - 2.0 * LAYER_M, marker.radius), DRUM_SRGB),
        ]

    def _add(self, mesh: Mesh, srgb: tuple[int, int, int]) -> int:
        """Return a body that is seen and touches nothing."""
        vertices, indices = mesh
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=vertices,
            indices=indices,
            normals=[[0.0, 0.0, 1.0]] * len(vertices),
            rgbaColor=[*(code / 255.0 for code in srgb), 1.0],
            physicsClientId=self._client,
        )
        body: int = pybullet.createMultiBody(0.0, -1, shape, physicsClientId=self._client)
        return body


def _view(optics: Optics) -> list[float]:
    """Return where the camera is, as OpenGL has it: a matrix, column by column."""
    axes = optics.rotation * np.array([[1.0], [-1.0], [-1.0]])  # OpenGL looks along -z and has y upwards
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = axes, -axes @ optics.position
    return view.T.ravel().tolist()


def _projection(focal: float, low: NDArray[np.intp], high: NDArray[np.intp]) -> list[float]:
    """Return the projection of a pinhole on a part of its image, as OpenGL has it.

    Parameters
    ----------
    focal : float
        [pixels].
    low, high : (2,) array
        Upper left and lower right corner (column, row), relative to the pinhole's axis [pixels].
    """
    (width, height), (right, down) = (high - low).tolist(), (high + low).tolist()
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 2.0 * focal / width, 2.0 * focal / height
    projection[0, 2], projection[1, 2] = right / width, -down / height
    projection[2, 2] = -(FAR_M + NEAR_M) / (FAR_M - NEAR_M)
    projection[2, 3] = -2.0 * FAR_M * NEAR_M / (FAR_M - NEAR_M)
    projection[3, 2] = -1.0
    return projection.T.ravel().tolist()


def _places(optics: Optics) -> FloatArray:
    """Return where in a pinhole's image the light of each pixel is found: (h, w, 2), column and row from its axis."""
    info = optics.info
    rows, columns = np.mgrid[: info.height, : info.width]
    rays = optics.rays(np.stack([columns, rows], axis=-1).astype(np.float64)) @ optics.rotation.T
    places: FloatArray = info.intrinsics[0, 0] * rays[..., :2] / rays[..., 2:]
    return places


def _disc(x: float, y: float, z: float, radius: float) -> Mesh:
    """Return a disc that faces up, in large triangles and few slivers: TinyRenderer looks at each one's whole box."""
    angles = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles), np.full(SEGMENTS, z)])
    third = SEGMENTS // 3
    indices = [0, third, 2 * third]
    for first in (0, third, 2 * third):
        indices += _segment(first, first + third)
    return ring.tolist(), indices


def _segment(first: int, last: int) -> list[int]:
    """Return the triangles between corners of a ring and the chord from the first to the last of them."""
    if last - first < 2:
        return []
    middle = (first + last) // 2
    return [first, middle, last % SEGMENTS, *_segment(first, middle), *_segment(middle, last)]


def _drum(height: float, radius: float) -> Mesh:
    """Return the side of a cylinder that stands on the floor, seen from outside."""
    angles = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    low, high = (np.column_stack([ring, np.full(SEGMENTS, z)]).tolist() for z in (0.0, height))
    indices = []
    for k in range(SEGMENTS):
        following = (k + 1) % SEGMENTS
        indices += [k, following, SEGMENTS + k, following, SEGMENTS + following, SEGMENTS + k]
    return [*low, *high], indices
