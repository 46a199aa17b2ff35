"""First placement of the circles, each as near to the center of the shape as it fits (Algorithm 1 of the thesis)."""

from __future__ import annotations

import math

import numpy as np

from swarm_msgs_py.partition.domain import Domain, Shortage
from swarm_msgs_py.partition.free_region import FreeRegion
from swarm_msgs_py.partition.rounding import direction, on_grid
from swarm_msgs_py.types import FloatArray

ALONG_X: FloatArray = np.array([1.0, 0.0])
TOUCH = 1e-9  # [m]; candidates lie on the boundary of what they must stay out of, up to rounding


def place(domain: Domain, first: int = 0) -> FloatArray | None:
    """Return the (n, 2) centers that `place_in_turn` finds; None if some circle finds no room.

    Parameters
    ----------
    domain : Domain
    first : int
        The circle that is placed first; those before it follow the last one. The second goes another way from it, too:
        each makes another cluster, from which a packing may settle better.
    """
    order = np.roll(np.arange(len(domain.radii)), -first)
    found = place_in_turn(domain.reordered(order), direction(float(first)))
    if len(found) < len(order):
        return None
    centers = np.empty_like(found)
    centers[order] = found
    return centers


def shortage(domain: Domain) -> Shortage | None:
    """Return where `place` runs out of room, None if it does not."""
    return Shortage.after(domain, np.arange(len(domain.radii)), len(place_in_turn(domain)))


def place_in_turn(domain: Domain, beside: FloatArray = ALONG_X) -> FloatArray:
    """Return a start for the packing: each circle in turn at the free point nearest to the boundary center.

    Parameters
    ----------
    domain : Domain
    beside : (2,) array
        Unit vector in which the second circle stands beside a first one at the center, where all ways are equal.

    Returns
    -------
    (m, 2) array
        Centers that keep all the gaps; m < n if circle m (counted from 0) finds no room.

    Notes
    -----
    The nearest point of a region bounded by segments and arcs is one of few: the target itself, the nearest point of a
    segment or of a circle, or a corner where two of those meet. Keeping these candidates while circles are added is
    exact, and 50 times faster than to subtract discs from polygons.
    """
    fields = {
        radius: _CandidateField(region, domain.center, beside, domain, radius)
        for radius, region in zip(domain.classes, domain.regions, strict=True)
    }
    centers = np.empty((len(domain.radii), 2))
    for index, radius in enumerate(domain.radii):
        best = fields[float(radius)].nearest()
        if best is None:
            return centers[:index]
        centers[index] = best
        for field in fields.values():
            field.add(best, float(radius))
    return centers


class _CandidateField:
    """Candidates for the nearest free point for circles of one radius."""

    def __init__(
        self, region: FreeRegion, target: FloatArray, beside: FloatArray, domain: Domain, radius: float
    ) -> None:
        self._region, self._target, self._beside = region, target, beside
        # Keep-out radius around a placed circle of each class.
        self._reach = {other: radius + other + domain.gaps.robot_m for other in domain.classes}
        self._centers = np.empty((0, 2))
        self._reaches = np.empty(0)
        first = target[None] if not region.is_empty and region.contains(target[None])[0] else np.empty((0, 2))
        self._candidates = np.concatenate([first, region.feet(target)])

    def nearest(self) -> FloatArray | None:
        """Return the free point nearest to the target, None if nothing is free."""
        if not len(self._candidates):
            return None
        squares = ((self._candidates - self._target) ** 2).sum(axis=1)
        best: FloatArray = self._candidates[np.argmin(on_grid(squares))]  # several are equal by symmetry
        return best

    def add(self, center: FloatArray, radius: float) -> None:
        """Take away the room of a circle that was placed at `center`."""
        if self._region.is_empty:
            return
        reach = self._reach[radius]
        apart = np.linalg.norm(self._candidates - center, axis=1)
        kept = self._candidates[apart >= reach - TOUCH]
        on_arcs = np.concatenate(
            [_toward(center, reach, self._target, self._beside), self._circle_corners(center, reach)]
        )
        fresh = np.concatenate([on_arcs[self._region.contains(on_arcs)], self._boundary_corners(center, reach)])
        self._candidates = np.concatenate([kept, self._outside_circles(fresh)])
        self._centers = np.concatenate([self._centers, center[None]])
        self._reaches = np.append(self._reaches, reach)

    def _outside_circles(self, points: FloatArray) -> FloatArray:
        apart = np.linalg.norm(points[:, None] - self._centers, axis=2)
        free: FloatArray = points[(apart >= self._reaches - TOUCH).all(axis=1)]
        return free

    def _circle_corners(self, center: FloatArray, reach: float) -> FloatArray:
        """Return where the new keep-out circle meets the earlier ones."""
        offsets = self._centers - center
        distances = np.linalg.norm(offsets, axis=1)
        meets = (distances < reach + self._reaches) & (distances > np.abs(reach - self._reaches))
        offsets, distances, others = offsets[meets], distances[meets], self._reaches[meets]
        along = (distances**2 + reach * reach - others**2) / (2.0 * distances)
        across = np.sqrt(np.maximum(reach * reach - along**2, 0.0))
        unit = offsets / distances[:, None]
        normal = np.column_stack([-unit[:, 1], unit[:, 0]])
        middle = center + along[:, None] * unit
        return np.concatenate([middle + across[:, None] * normal, middle - across[:, None] * normal])

    def _boundary_corners(self, center: FloatArray, reach: float) -> FloatArray:
        """Return where the new keep-out circle meets the boundary of the region."""
        edges = self._region.ends - self._region.starts
        offsets = self._region.starts - center
        a = (edges**2).sum(axis=1)
        b = (edges * offsets).sum(axis=1)
        discriminant = b**2 - a * ((offsets**2).sum(axis=1) - reach * reach)
        root = np.sqrt(np.maximum(discriminant, 0.0))
        corners = []
        for along in ((-b - root) / a, (-b + root) / a):
            meets = (discriminant > 0.0) & (along >= 0.0) & (along <= 1.0)
            corners.append(self._region.starts[meets] + along[meets, None] * edges[meets])
        return np.concatenate(corners)


def _toward(center: FloatArray, reach: float, target: FloatArray, beside: FloatArray) -> FloatArray:
    """Return the point of a circle that is nearest to the target, (1, 2); around the target, that toward `beside`."""
    offset = target - center
    distance = math.sqrt(float(offset[0] * offset[0] + offset[1] * offset[1]))  # a norm of one vector goes by BLAS
    unit = offset / distance if distance > TOUCH else beside
    return (center + reach * unit)[None]
