"""Draws what the camera sees: a floor with marks, and robots as dark drums with two discs on their covers.

Each pixel's ray is followed once, at the start, to the planes in which discs lie. A frame then only needs the signed
distance of the pixels around each robot from each of its circles; edges are anti-aliased exactly (`coverage`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from swarm_msgs_py.light import linear_of
from swarm_msgs_py.markers import PRINTED_SRGB, CoverMarker, FloorMarks, MarkerColor
from swarm_msgs_py.types import FloatArray
from swarm_sim.camera.coverage import Pixels, edge_coverage
from swarm_sim.camera.exposure import LightArray, codes_of
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.windows import Window, window_around

FLOOR_SRGB, BLACK_SRGB, DRUM_SRGB = (190, 190, 188), (38, 38, 40), (58, 58, 60)
"""Floor; covers and marks; the side of a robot, which catches some light."""
FLOOR_GRAIN = 0.03
"""Relative roughness of the floor's brightness, in patches of a few pixels."""
DRUM_LEVELS = 2
"""Circles that stand for the side of a robot below its cover."""


@dataclass(frozen=True, slots=True)
class Spot:
    """A disc on the floor that belongs to no robot.

    Attributes
    ----------
    color : MarkerColor
    center : (x, y)
        [m].
    radius : float
        [m].
    """

    color: MarkerColor
    center: tuple[float, float]
    radius: float


class Raster:
    """Draws the arena as seen through one camera.

    Parameters
    ----------
    optics : Optics
    markers : sequence of CoverMarker
        One per robot, in the order in which poses are given.
    marks : FloorMarks
    light : (h, w, 3) float32 array
        Illumination of each pixel.
    rng : Generator
        Draws the grain of the floor.
    spot_px : float
        Side of the square that the lens spreads a point over [pixels].
    """

    def __init__(  # noqa: PLR0913, PLR0917 - a scene, a camera and their light
        self,
        optics: Optics,
        markers: Sequence[CoverMarker],
        marks: FloorMarks,
        light: LightArray,
        rng: np.random.Generator,
        spot_px: float = 1.0,
    ) -> None:
        self._optics, self._markers, self._spot_px = optics, tuple(markers), spot_px
        self._gain = light
        self._inks = {color: linear_of(srgb).astype(np.float32) for color, srgb in PRINTED_SRGB.items()}
        self._black, self._drum = (linear_of(srgb).astype(np.float32) for srgb in (BLACK_SRGB, DRUM_SRGB))
        levels = sorted({level for marker in markers for level in _levels(marker)} | {0.0})
        rows, columns = np.mgrid[: optics.info.height, : optics.info.width]
        rays = optics.rays(np.stack([columns, rows], axis=-1).astype(np.float64))
        self._planes = {level: optics.plane_points(rays, level).astype(np.float32) for level in levels}
        self._light = np.empty_like(light)
        self._light[:] = linear_of(FLOOR_SRGB).astype(np.float32)
        self._light *= _grain(light.shape[:2], rng)[:, :, None]
        for center in marks.centers:
            self._disc(self._light, 0.0, (float(center[0]), float(center[1])), marks.radius, self._black)
        self._floor_codes = codes_of(self._light * light)

    def draw(self, positions: FloatArray, yaws: FloatArray, spots: Sequence[Spot] = ()) -> LightArray:
        """Return the codes (h, w, 3), not rounded, of robots at positions (n, 2) [m] with headings (n,) [rad].

        Robots must not overlap. Spots are drawn first, so that robots stand on them.
        """
        light, codes = self._light.copy(), self._floor_codes.copy()
        touched = [self._disc(light, 0.0, spot.center, spot.radius, self._inks[spot.color]) for spot in spots]
        poses = list(zip(self._markers, positions.tolist(), yaws.tolist(), strict=True))
        for marker, (x, y), _ in poses:
            touched += [self._disc(light, level, (x, y), marker.radius, self._drum) for level in _levels(marker)[:-1]]
        # Covers are all drawn after all sides, since a cover near the middle may hide the side of a robot behind it.
        for marker, (x, y), yaw in poses:
            ink = self._inks[marker.color]
            ahead = np.array([np.cos(yaw), np.sin(yaw)])
            touched.append(self._disc(light, marker.height, (x, y), marker.radius, self._black))
            for place, radius in (
                (marker.large_place, marker.large_radius),
                (marker.small_place, marker.small_radius),
            ):
                dx, dy = (place * ahead).tolist()
                self._disc(light, marker.height, (x + dx, y + dy), radius, ink)
        for part in touched:
            if part is None:
                continue
            codes[part] = codes_of(light[part] * self._gain[part])
        return codes

    def close(self) -> None:
        """Do nothing: there is nothing to free."""

    def _disc(
        self, light: LightArray, level: float, center: tuple[float, float], radius: float, ink: NDArray[np.float32]
    ) -> Window | None:
        """Draw a disc into `light`, in place; return what of it may have changed, None if the disc is out of view."""
        part = window_around(self._optics, np.array(center), radius, (level,))
        if part is None:
            return None
        offset = self._planes[level][part] - np.array(center, dtype=np.float32)
        distances: Pixels = np.sqrt(np.einsum("ijk,ijk->ij", offset, offset)) - np.float32(radius)
        covered = edge_coverage(distances, self._spot_px)[:, :, None]
        light[part] += covered * (ink - light[part])
        return part


def _levels(marker: CoverMarker) -> list[float]:
    """Return the heights of the circles that a robot is drawn with; the last is its cover."""
    return [marker.height * k / DRUM_LEVELS for k in range(DRUM_LEVELS + 1)]


def _grain(shape: tuple[int, int], rng: np.random.Generator) -> LightArray:
    """Return the relative brightness of the floor in each pixel."""
    patch = 6
    coarse = rng.normal(size=(shape[0] // patch + 1, shape[1] // patch + 1))
    fine = np.kron(coarse, np.ones((patch, patch)))[: shape[0], : shape[1]]
    grain: LightArray = np.clip(1.0 + FLOOR_GRAIN * fine, 0.8, 1.2).astype(np.float32)
    return grain
