"""What the images of the camera study show: five robots anywhere, and what makes them hard to read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.markers import CoverMarker, MarkerColor
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.raster import Spot

COVERAGE_RADII_M = {
    MarkerColor.RED: 0.16,
    MarkerColor.BLUE: 0.11,
    MarkerColor.GREEN: 0.11,
    MarkerColor.YELLOW: 0.08,
    MarkerColor.PINK: 0.08,
}
"""Thesis table 5.1."""
ARENA_HALF_M = 1.0
BEYOND_M = 0.2
"""How far past the edge of the arena robots are put in images in which some are partly out of view."""
TOUCHING_M = 0.002
"""Largest gap between robots that are made to touch."""
FAR_AWAY_M = 30.0
SPOTS_MAX = 3
SPOT_RADII_M = (0.01, 0.07)
VIEW_MARGIN_PX = 1.0
P_TOUCHING, P_BEYOND, P_MISSING, P_SPOTS, P_BLACK = 0.3, 0.15, 0.15, 0.3, 0.05
"""Shares of images with robots that touch, robots partly out of view, a robot missing, colored spots on the floor, and
the left half black; drawn independently."""


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """What one image shows.

    Attributes
    ----------
    positions : (n, 2) array
        [m]; a missing robot is far away.
    yaws : (n,) array
        [rad].
    spots : tuple of Spot
    is_half_black : bool
    """

    positions: FloatArray
    yaws: FloatArray
    spots: tuple[Spot, ...]
    is_half_black: bool


def arena_markers() -> tuple[CoverMarker, ...]:
    """Return the covers of the five robots of the thesis."""
    return tuple(
        CoverMarker(robot=NodeId(number), color=color, radius=radius)
        for number, (color, radius) in enumerate(COVERAGE_RADII_M.items())
    )


def plain_case(markers: Sequence[CoverMarker], rng: np.random.Generator) -> Case:
    """Return robots inside the arena, apart from each other, and nothing else."""
    positions = _placed(markers, ARENA_HALF_M, 0.0, rng)
    return Case(positions, _yaws(markers, rng), (), is_half_black=False)


def hard_case(markers: Sequence[CoverMarker], rng: np.random.Generator) -> Case:
    """Return robots and what makes them hard to read."""
    touching, beyond, missing, spotted, black = rng.random(5) < (P_TOUCHING, P_BEYOND, P_MISSING, P_SPOTS, P_BLACK)
    half = ARENA_HALF_M + BEYOND_M if beyond else ARENA_HALF_M
    positions = _placed(markers, half, float(touching), rng)
    if missing:
        positions[rng.integers(len(markers))] = FAR_AWAY_M
    spots = _spots(markers, rng) if spotted else ()
    return Case(positions, _yaws(markers, rng), spots, bool(black))


def in_view(case: Case, markers: Sequence[CoverMarker], optics: Optics) -> BoolArray:
    """Return whose whole cover (n,) the image shows."""
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    low = np.array([VIEW_MARGIN_PX, VIEW_MARGIN_PX])
    high = np.array([optics.info.width, optics.info.height]) - 1.0 - VIEW_MARGIN_PX
    if case.is_half_black:
        low[0] = optics.info.width // 2 + VIEW_MARGIN_PX
    seen = []
    for marker, (x, y) in zip(markers, case.positions.tolist(), strict=True):
        pixels = optics.project(marker.radius * circle + (x, y, marker.height))
        # The lens is only known near the image: what is far away must not be folded back into it.
        seen.append(max(abs(x), abs(y)) < FAR_AWAY_M / 2.0 and bool(((pixels >= low) & (pixels <= high)).all()))
    return np.array(seen)


def _placed(markers: Sequence[CoverMarker], half: float, p_touching: float, rng: np.random.Generator) -> FloatArray:
    """Return positions (n, 2) without overlap, drawn until they fit; with `p_touching`, some robots touch another."""
    radii = np.array([marker.radius for marker in markers])
    positions = np.zeros((len(markers), 2))
    for row, radius in enumerate(radii):
        others, reach = positions[:row], radii[:row] + radius
        while True:
            room = half - radius if half <= ARENA_HALF_M else half
            point = rng.uniform(-room, room, 2)
            if row and rng.random() < p_touching / 2.0:
                other, angle = rng.integers(row), rng.uniform(0.0, 2.0 * np.pi)
                apart = reach[other] + rng.uniform(0.0, TOUCHING_M)
                point = others[other] + apart * np.array([np.cos(angle), np.sin(angle)])
            is_inside = bool((np.abs(point) <= room).all())
            if is_inside and bool((np.hypot(*(others - point).T) >= reach).all()):
                break
        positions[row] = point
    return positions


def _yaws(markers: Sequence[CoverMarker], rng: np.random.Generator) -> FloatArray:
    return rng.uniform(-np.pi, np.pi, len(markers))


def _spots(markers: Sequence[CoverMarker], rng: np.random.Generator) -> tuple[Spot, ...]:
    """Return spots in the robots' colors; half of them have exactly the size of a disc."""
    spots = []
    for _ in range(rng.integers(1, SPOTS_MAX + 1)):
        marker = markers[int(rng.integers(len(markers)))]
        x, y = rng.uniform(-ARENA_HALF_M, ARENA_HALF_M, 2)
        sizes = (marker.large_radius, marker.small_radius, *rng.uniform(*SPOT_RADII_M, 2))
        spots.append(Spot(marker.color, (float(x), float(y)), float(sizes[rng.integers(4)])))
    return tuple(spots)
