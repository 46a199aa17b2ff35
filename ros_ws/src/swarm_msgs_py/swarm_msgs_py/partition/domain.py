"""The problem that every partition method solves: a contour, obstacles, and the circles to put between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from shapely import Polygon

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import boundary_center, signed_area
from swarm_msgs_py.partition.config import Gaps
from swarm_msgs_py.partition.free_region import FreeRegion, free_region
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.types import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Domain:
    """Where goals may be.

    Attributes
    ----------
    contour : (k, 2) array
        Shape, simple and counter-clockwise [m].
    obstacles : tuple of (m, 2) array
        Polygons that no circle may touch [m].
    radii : (n,) array
        Radius of each circle [m].
    gaps : Gaps
        Least free distances [m].
    """

    contour: FloatArray
    obstacles: tuple[FloatArray, ...]
    radii: FloatArray
    gaps: Gaps

    @cached_property
    def area(self) -> float:
        """Area inside the contour [m^2]."""
        return signed_area(self.contour)

    @cached_property
    def center(self) -> FloatArray:
        """Boundary center z_c of the contour, (2,) [m]."""
        return boundary_center(self.contour)

    @cached_property
    def spacing(self) -> float:
        """Distance between neighbors when the n circles stand on a hexagonal lattice that fills the area [m]."""
        return float(np.sqrt(2.0 * self.area / (np.sqrt(3.0) * len(self.radii))))

    @cached_property
    def classes(self) -> tuple[float, ...]:
        """The different radii, ascending [m]."""
        return tuple(float(radius) for radius in np.unique(self.radii))

    @cached_property
    def regions(self) -> tuple[FreeRegion, ...]:
        """Where the centers of each class of circles may be, in the order of `classes`."""
        gaps = self.gaps
        return tuple(
            free_region(self.contour, self.obstacles, radius, gaps.contour_m, gaps.obstacle_m)
            for radius in self.classes
        )

    @cached_property
    def least_distances(self) -> FloatArray:
        """Least distance between each two centers, (n, n) with a zero diagonal [m]."""
        distances: FloatArray = self.radii[:, None] + self.radii + self.gaps.robot_m
        np.fill_diagonal(distances, 0.0)
        return distances

    def reordered(self, order: IntArray) -> Domain:
        """Return the same problem with the circles in another order."""
        return Domain(self.contour, self.obstacles, self.radii[order], self.gaps)

    def entering(self, frame: OwnFrame) -> Domain:
        """Return the same problem in a frame of reference."""
        obstacles = tuple(frame.enter(outline) for outline in self.obstacles)
        return Domain(frame.enter(self.contour), obstacles, self.radii, self.gaps)

    def scaled(self, factor: float) -> Domain:
        """Return the problem with the contour scaled about its center and without obstacles."""
        return Domain(self.center + factor * (self.contour - self.center), (), self.radii, self.gaps)


@dataclass(frozen=True, slots=True)
class Shortage:
    """Where a method ran out of room.

    Attributes
    ----------
    circle : int
        The circle that found no room.
    placed : int
        How many circles had found room before.
    free_area : float
        Area of the shape that they do not cover [m^2].
    """

    circle: int
    placed: int
    free_area: float

    @classmethod
    def after(cls, domain: Domain, order: IntArray, placed: int) -> Shortage | None:
        """Return the shortage when this many circles, in this order, found room; None if all did."""
        if placed == len(order):
            return None
        covered = float(np.pi * (domain.radii[order[:placed]] ** 2).sum())
        return cls(int(order[placed]), placed, domain.area - covered)


def check_obstacles(contour: FloatArray, obstacles: tuple[FloatArray, ...]) -> None:
    """Refuse a shape that lies over an obstacle of the map.

    Raises
    ------
    ShapeError
        Naming the obstacle, its place and the area that is covered.
    """
    shape = Polygon(contour)
    for index, outline in enumerate(obstacles):
        obstacle = Polygon(outline)
        covered = shape.intersection(obstacle)
        if covered.area > 0.0:
            x, y = obstacle.centroid.x, obstacle.centroid.y
            raise ShapeError(
                f"obstacle {index + 1} at ({x:.1f}, {y:.1f}) covers {covered.area:.2g} m2 of the shape;"
                " move the shape or the obstacle"
            )
