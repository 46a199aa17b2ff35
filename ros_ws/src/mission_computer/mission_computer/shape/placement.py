"""Where a shape goes: how large, how turned, and where its center is."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True)
class Placement:
    """What is done to a shape, in this order; sizes and turns leave its center of area where it is.

    Attributes
    ----------
    fit : (width, height) or None
        It is made as large as it can be in a box of this size [m].
    area : float or None
        It is given this area [m^2].
    scale : float
        Size factor, > 0.
    rotation : float
        Turn, counter-clockwise [rad].
    center : (x, y) or None
        Where its center of area is put [m].
    translation : (x, y)
        Shift after that [m].
    """

    fit: tuple[float, float] | None = None
    area: float | None = None
    scale: float = 1.0
    rotation: float = 0.0
    center: tuple[float, float] | None = None
    translation: tuple[float, float] = (0.0, 0.0)

    def check(self, name: str) -> None:
        """Refuse numbers that are no placement.

        Raises
        ------
        ShapeError
        """
        for what, numbers in {"scale": (self.scale,), "fit": self.fit or (), "area": (self.area or 1.0,)}.items():
            for number in numbers:
                if not (math.isfinite(number) and number > 0.0):
                    raise ShapeError(f"{name}: {what} must be a number > 0, got {number:g}")
        if not all(math.isfinite(number) for number in (self.rotation, *self.translation, *(self.center or ()))):
            raise ShapeError(
                f"{name}: rotation, center and translation must be finite, got {self.rotation:g}, {self.center} and"
                f" {self.translation}"
            )

    @property
    def is_none(self) -> bool:
        """Whether nothing is done."""
        return self == Placement()

    def factor(self, size: tuple[float, float], area: float) -> float:
        """Return how many times as large a shape becomes that has this width and height [m] and area [m^2]."""
        factor = self.scale
        if self.fit is not None:
            factor *= min(self.fit[0] / size[0], self.fit[1] / size[1])
        if self.area is not None:
            factor *= math.sqrt(self.area / area)
        return factor

    def moved(self, points: FloatArray, center: FloatArray, factor: float) -> FloatArray:
        """Return (n, 2) points of a shape with this center of area, made `factor` times as large, turned and put."""
        turn = np.array(
            [
                [math.cos(self.rotation), math.sin(self.rotation)],
                [-math.sin(self.rotation), math.cos(self.rotation)],
            ]
        )
        place = center if self.center is None else np.array(self.center)
        moved: FloatArray = place + factor * (points - center) @ turn + self.translation
        return moved

    def of_region(self, region: BaseGeometry) -> BaseGeometry:
        """Return a region placed."""
        left, low, right, high = region.bounds
        center = shapely.get_coordinates(region.centroid)[0]
        factor = self.factor((right - left, high - low), region.area)
        return shapely.transform(region, lambda points: self.moved(points, center, factor))
