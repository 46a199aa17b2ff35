"""The arena as PyBullet's software renderer draws it: meshes with hard edges, bent by the lens afterwards.

A second, independent picture of the same scene. It takes about ten times as long as `raster`, which is why it is not
the default; it needs no physics engine of the run, only a server of its own that holds what is to be seen.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import map_coordinates

from swarm_msgs_py.markers import PRINTED_SRGB, CoverMarker, FloorMarks
from swarm_msgs_py.types import FloatArray
from swarm_sim.bullet import open_server, pybullet
from swarm_sim.camera.exposure import LightArray, codes_of, light_of
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.raster import BLACK_SRGB, DRUM_SRGB, FLOOR_SRGB, Spot

SEGMENTS = 64
"""Corners of a disc: its area is off by less than 0.2 %."""
LAYER_M = 2e-4
"""What is printed on something lies this much above it [m], so that it hides it."""
WIDER = 1.15
"""The image before the lens, relative to the one behind it: a barrel lens sees farther at its edges."""
NEAR_M, FAR_M = 0.3, 12.0
FLOOR_HALF_M = 4.0
Mesh = tuple[list[list[float]], list[int]]


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

    Raises
    ------
    PhysicsError
        If the engine does not start.
    """

    def __init__(self, optics: Optics, markers: Sequence[CoverMarker], marks: FloorMarks, light: LightArray) -> None:
        self._light = light
        info = optics.info
        self._size = round(WIDER * info.width), round(WIDER * info.height)
        self._view, self._projection = _matrices(optics, self._size)
        self._samples = _samples(optics, self._size)
        self._client = open_server()
        half = FLOOR_HALF_M
        floor = [[-half, -half, 0.0], [half, -half, 0.0], [half, half, 0.0], [-half, half, 0.0]]
        self._add((floor, [0, 1, 2, 0, 2, 3]), FLOOR_SRGB)
        for x, y in marks.centers.tolist():
            self._add(_disc(x, y, LAYER_M, marks.radius), BLACK_SRGB)
        self._robots = [self._add_robot(marker) for marker in markers]

    def draw(self, positions: FloatArray, yaws: FloatArray, spots: Sequence[Spot] = ()) -> LightArray:
        """Return the codes (h, w, 3) of robots at positions (n, 2) [m] with headings (n,) [rad]; see `Raster.draw`."""
        client = self._client
        for parts, (x, y), yaw in zip(self._robots, positions.tolist(), yaws.tolist(), strict=True):
            turned = (0.0, 0.0, float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0)))
            for part in parts:
                pybullet.resetBasePositionAndOrientation(part, (x, y, 0.0), turned, physicsClientId=client)
        lying = [self._add(_disc(*spot.center, LAYER_M, spot.radius), PRINTED_SRGB[spot.color]) for spot in spots]
        width, height = self._size
        _, _, pixels, _, _ = pybullet.getCameraImage(
            width,
            height,
            self._view,
            self._projection,
            shadow=0,
            lightAmbientCoeff=1.0,  # colors as printed: light and its gradient come afterwards
            lightDiffuseCoeff=0.0,
            lightSpecularCoeff=0.0,
            renderer=pybullet.ER_TINY_RENDERER,
            physicsClientId=client,
        )
        for body in lying:
            pybullet.removeBody(body, physicsClientId=client)
        drawn = light_of(np.asarray(pixels, dtype=np.uint8).reshape(height, width, -1)[:, :, :3])
        bent = [map_coordinates(drawn[:, :, channel], self._samples, order=1, mode="nearest") for channel in range(3)]
        return codes_of(np.stack(bent, axis=-1) * self._light)

    def close(self) -> None:
        """Stop the server; may be called again."""
        if self._client >= 0:
            pybullet.disconnect(self._client)
            self._client = -1

    def _add_robot(self, marker: CoverMarker) -> list[int]:
        """Return the bodies that a robot consists of: drum, cover and two discs."""
        top = marker.height
        return [
            self._add(_drum(top - 2.0 * LAYER_M, marker.radius), DRUM_SRGB),
            self._add(_disc(0.0, 0.0, top - LAYER_M, marker.radius), BLACK_SRGB),
            self._add(_disc(marker.large_place, 0.0, top, marker.large_radius), PRINTED_SRGB[marker.color]),
            self._add(_disc(marker.small_place, 0.0, top, marker.small_radius), PRINTED_SRGB[marker.color]),
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


def _matrices(optics: Optics, size: tuple[int, int]) -> tuple[list[float], list[float]]:
    """Return view and projection of a perfect pinhole in the camera's place, column by column as OpenGL has them."""
    axes = optics.rotation * np.array([[1.0], [-1.0], [-1.0]])  # OpenGL looks along -z and has y upwards
    view = np.eye(4)
    view[:3, :3], view[:3, 3] = axes, -axes @ optics.position
    fx, fy = optics.info.intrinsics[0, 0], optics.info.intrinsics[1, 1]
    projection = np.zeros((4, 4))
    projection[0, 0], projection[1, 1] = 2.0 * fx / size[0], 2.0 * fy / size[1]
    projection[2, 2] = -(FAR_M + NEAR_M) / (FAR_M - NEAR_M)
    projection[2, 3] = -2.0 * FAR_M * NEAR_M / (FAR_M - NEAR_M)
    projection[3, 2] = -1.0
    return view.T.ravel().tolist(), projection.T.ravel().tolist()


def _samples(optics: Optics, size: tuple[int, int]) -> FloatArray:
    """Return where in the pinhole's image the light of each pixel is found: (2, h, w), rows then columns."""
    info = optics.info
    rows, columns = np.mgrid[: info.height, : info.width]
    rays = optics.rays(np.stack([columns, rows], axis=-1).astype(np.float64)) @ optics.rotation.T
    straight = rays[..., :2] / rays[..., 2:]
    # TinyRenderer samples a pixel at its lower left corner, and then turns the image over.
    across = info.intrinsics[0, 0] * straight[..., 0] + size[0] / 2.0
    down = info.intrinsics[1, 1] * straight[..., 1] + size[1] / 2.0 - 1.0
    return np.stack([down, across])


def _disc(x: float, y: float, z: float, radius: float) -> Mesh:
    """Return a disc that faces up, as a fan of triangles."""
    angles = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles), np.full(SEGMENTS, z)])
    indices = [corner for k in range(SEGMENTS) for corner in (SEGMENTS, k, (k + 1) % SEGMENTS)]
    return [*ring.tolist(), [x, y, z]], indices


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
