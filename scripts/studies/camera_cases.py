"""What the images of the camera study show: five robots anywhere, and what makes them hard to read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from swarm_msgs_py.markers import CoverMarker, MarkerColor
from swarm_msgs_py.messages.camera import CameraImage
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId
from swarm_sim.camera.optics import Optics
from swarm_sim.camera.overhead_camera import OverheadCamera, blacken_half
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
P_TOUCHING, P_BEYOND, P_MISSING, P_SPOTS, P_BLACK, P_TWIN = 0.3, 0.15, 0.15, 0.3, 0.05, 0.1
"""Shares of images with robots that touch, robots partly out of view, a robot missing, colored spots on the floor, the
left half black, and a look-alike of a robot; drawn independently."""
P_TWIN_ALONE = 0.5
"""Share of look-alikes whose robot does not show."""


@dataclass(frozen=True, slots=True, eq=False)
class LookAlike:
    """A second cover of one robot, as high as the first.

    No image by itself tells the two apart, but robots do not leap: so a look-alike appears while robots are watched.

    Attributes
    ----------
    row : int
        Of the robot.
    position : (2,) array
        [m].
    yaw : float
        [rad].
    before : (n, 2) array
        Where robots were in the image before, without the look-alike [m].
    """

    row: int
    position: FloatArray
    yaw: float
    before: FloatArray


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
    twin : LookAlike or None
    """

    positions: FloatArray
    yaws: FloatArray
    spots: tuple[Spot, ...]
    is_half_black: bool
    twin: LookAlike | None = None


def arena_markers() -> tuple[CoverMarker, ...]:
    """Return the covers of the five robots of the thesis."""
    return tuple(
        CoverMarker(robot=NodeId(number), color=color, radius=radius)
        for number, (color, radius) in enumerate(COVERAGE_RADII_M.items())
    )


def covers() -> tuple[CoverMarker, ...]:
    """Return all covers that a camera of the study may see: those of the robots, and a look-alike of each."""
    markers = arena_markers()
    return markers + tuple(replace(marker, robot=NodeId(len(markers) + marker.robot)) for marker in markers)


def shot(camera: OverheadCamera, number: int, time: float, case: Case) -> CameraImage:
    """Return the image of a case, taken by a camera of all `covers` that nobody switched off.

    Parameters
    ----------
    camera : OverheadCamera
    number : int
        Of the image; names its noise.
    time : float
        [s].
    case : Case
    """
    others, turns = np.full_like(case.positions, FAR_AWAY_M), np.zeros_like(case.yaws)
    if case.twin is not None:
        others[case.twin.row], turns[case.twin.row] = case.twin.position, case.twin.yaw
    everyone, yaws = np.concatenate([case.positions, others]), np.concatenate([case.yaws, turns])
    image = camera.take(number, time, everyone, yaws, case.spots)
    assert image is not None
    if case.is_half_black:
        blacken_half(image.pixels)
    return image


def before(case: Case) -> Case | None:
    """Return what the image before shows if the case is one that only tracks can decide, else None."""
    return None if case.twin is None else Case(case.twin.before, case.yaws, (), is_half_black=False)


def plain_case(markers: Sequence[CoverMarker], rng: np.random.Generator) -> Case:
    """Return robots inside the arena, apart from each other, and nothing else."""
    positions = _placed(markers, ARENA_HALF_M, 0.0, rng)
    return Case(positions, _yaws(markers, rng), (), is_half_black=False)


def hard_case(markers: Sequence[CoverMarker], rng: np.random.Generator) -> Case:
    """Return robots and what makes them hard to read."""
    touching, beyond, missing, spotted, black, twofold = rng.random(6) < (
        *(P_TOUCHING, P_BEYOND, P_MISSING, P_SPOTS),
        *(P_BLACK, P_TWIN),
    )
    half = ARENA_HALF_M + BEYOND_M if beyond else ARENA_HALF_M
    positions = _placed(markers, half, float(touching), rng)
    if missing:
        positions[rng.integers(len(markers))] = FAR_AWAY_M
    spots = _spots(markers, rng) if spotted else ()
    yaws = _yaws(markers, rng)
    twin = _look_alike(markers, positions, rng) if twofold else None
    if twin is not None and rng.random() < P_TWIN_ALONE:
        positions = positions.copy()
        positions[twin.row] = FAR_AWAY_M
    return Case(positions, yaws, spots, bool(black), twin)


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


def _look_alike(markers: Sequence[CoverMarker], positions: FloatArray, rng: np.random.Generator) -> LookAlike | None:
    """Return a look-alike of a robot that is inside the arena, beside all robots at (n, 2) [m]; None if none is."""
    radii = np.array([marker.radius for marker in markers])
    inside = np.flatnonzero(np.abs(positions).max(axis=1) + radii <= ARENA_HALF_M)
    if not len(inside):
        return None
    row = int(rng.choice(inside))
    while True:
        place = rng.uniform(radii[row] - ARENA_HALF_M, ARENA_HALF_M - radii[row], 2)
        if bool((np.hypot(*(positions - place).T) >= radii + radii[row]).all()):
            return LookAlike(row, place, float(rng.uniform(-np.pi, np.pi)), positions)


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
