"""Randomized fractals: circles at random points of what is still free, largest first (thesis 3.2.2.2, Algorithm 2)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.partition.config import CircleSizes, FractalConfig, Gaps
from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.free_region import free_polygon
from swarm_msgs_py.partition.hurwitz import hurwitz_radii
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, IntArray

ARC_SEGMENTS = 32  # chords per quarter circle; discs are enlarged so that their chords stay outside the true circle
OUTSIDE = 1.0 / math.cos(math.pi / (4.0 * ARC_SEGMENTS))
AREA_MIN = 1e-6  # [m^2]; parts of the free space below this are left out: nothing would ever be drawn in them
BATCH = 64  # points drawn at a time until one of them is in the free space


class RandomizedFractals:
    """The partition method of the thesis' section 3.2.2.2.

    Circles are drawn largest first, because small ones find room between large ones and not the other way round. How
    far that goes, for the three sizes of the thesis: draws always succeed while the circles have up to 0.53 of the
    area, about half of them at 0.62, none at 0.70 or more; in ascending order draws already fail at 0.46.

    Goals nearer to each other than robots avoid each other can hardly be held, so a first draw keeps the wanted
    clearance; only where it finds no room, a second one goes down to the least gaps.

    Parameters
    ----------
    config : FractalConfig
        Tuning and the seed of the draws.
    """

    def __init__(self, config: FractalConfig) -> None:
        self._config = config

    def shortage(self, domain: Domain) -> Shortage | None:
        """Return the circle that found no room, None if all did; draws are repeatable, so `place` does the same."""
        return Shortage.after(domain, _descending(domain), len(self._drawn(domain)))

    def place(self, domain: Domain) -> FloatArray | None:
        """Return the (n, 2) centers of the circles, which keep all gaps; None if a circle finds no room."""
        centers = self._drawn(domain)
        if len(centers) < len(domain.radii):
            return None
        placed = np.empty_like(centers)
        placed[_descending(domain)] = centers
        return placed

    def _drawn(self, domain: Domain) -> FloatArray:
        """Return the centers of the circles that find room, in the order in which they are drawn."""
        frame, gaps, wanted = OwnFrame(domain.contour), domain.gaps, self._config.clearance_m
        own = domain.reordered(_descending(domain)).entering(frame)
        wide = replace(gaps, robot_m=max(gaps.robot_m, wanted), contour_m=max(gaps.contour_m, wanted / 2.0))
        tries = (gaps,) if wide == gaps or self._config.sizes is CircleSizes.HURWITZ else (wide, gaps)
        for number, kept in enumerate(tries):
            centers = self._draw(own, kept, rng_for(self._config.seed or 0, "fractals", number))
            if len(centers) == len(domain.radii):
                break
        return frame.leave(centers)

    def _draw(self, domain: Domain, gaps: Gaps, rng: np.random.Generator) -> FloatArray:
        """Return (m, 2) centers; m < n if circle m (counted from 0) finds no room."""
        sizes = self._sizes(domain, gaps)
        centers = np.empty((len(sizes), 2))
        free: BaseGeometry = shapely.Polygon()
        for index, size in enumerate(sizes):
            before = slice(index - 1, index) if index and size == sizes[index - 1] else slice(0, index)
            if before.start == 0:
                free = free_polygon(domain.contour, domain.obstacles, size, gaps.contour_m, gaps.obstacle_m)
            reaches = OUTSIDE * (size + sizes[before] + self._gap(gaps))
            discs = shapely.buffer(shapely.points(centers[before]), reaches, quad_segs=ARC_SEGMENTS)
            free = free.difference(shapely.union_all(discs))
            point = _uniform_point(free, rng)
            if point is None:
                return centers[:index]
            centers[index] = point
        return centers

    def _sizes(self, domain: Domain, gaps: Gaps) -> FloatArray:
        """Return the radius that each circle keeps to itself, largest first [m]."""
        if self._config.sizes is CircleSizes.COVERAGE:
            return domain.radii
        config = self._config
        prescribed = hurwitz_radii(domain.area, len(domain.radii), config.exponent, config.shift)
        return np.maximum(prescribed, domain.radii + gaps.robot_m / 2.0)

    def _gap(self, gaps: Gaps) -> float:
        """Return the gap between circles [m]; Hurwitz' circles may touch, for the robots in them are smaller."""
        return gaps.robot_m if self._config.sizes is CircleSizes.COVERAGE else 0.0


def _descending(domain: Domain) -> IntArray:
    """Return the circles in the order in which they are drawn."""
    return np.argsort(-domain.radii, kind="stable")


def _uniform_point(free: BaseGeometry, rng: np.random.Generator) -> FloatArray | None:
    """Return a point drawn evenly from a region, (2,), None if the region is empty."""
    parts = [part for part in shapely.get_parts(free) if part.area > AREA_MIN]
    if not parts:
        return None
    heaps = np.cumsum([part.area for part in parts])
    part = parts[int(np.searchsorted(heaps, rng.uniform(0.0, heaps[-1]), side="right").clip(max=len(parts) - 1))]
    shapely.prepare(part)
    low, high = np.array(part.bounds[:2]), np.array(part.bounds[2:])
    while True:
        points = low + rng.random((BATCH, 2)) * (high - low)
        inside = shapely.contains_xy(part, points)
        if inside.any():
            point: FloatArray = points[np.argmax(inside)]
            return point
