"""Walls as landmarks: what the proximity sensor sees of a wall that the map knows says how far away the robot is.

A robot drives along walls whose place it knows only relative to its own estimate. An error of half a meter is enough to
steer it against a corner of which it believes to be clear, and there it stands. But a wall is also the best landmark
around: seen to within millimeters, at a place that does not change.

A sensed point may as well be another robot. It is taken for a wall if a face or a corner looks at the robot from just
that direction, if no other one could be meant, and if nobody who was heard lately may stand there. Seen face to face, a
wall also does not end before the robot: that tells one that has come to the end of a long wall from one that only
believes it has.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_agent.localization.hypotheses import widest
from swarm_msgs_py.types import BoolArray, FloatArray

ASKEW = math.radians(12.0)
"""A face is seen along its normal, give or take this angle; a corner from between the normals of its faces, at least so
far from both, where none of the faces is meant [rad]."""

SIGMAS = 2.0
"""Standard deviations of the distance to a neighbor within which a point may be that neighbor. More would be safer, and
keep a robot that is not sure of its place from the walls that could tell it."""

SURPRISE_MAX, CLEARLY = 9.0, 6.0
"""A wall is meant if it fits within three standard deviations, and any other one is twenty times less probable."""

FIT_M = 0.1
"""How far a seen wall may be off besides: heading, map and sensor [m]."""

ROBOT_M = 0.8
"""How far from a neighbor's center a point of that neighbor may be: the largest radius, and its motion in a tick."""

TEMPER = 0.1
"""Weight of one look: the next look at the same wall says hardly anything new about which wall it is."""


@dataclass(frozen=True, slots=True, eq=False)
class Recognition:
    """What the sensed walls say of a position.

    Attributes
    ----------
    directions : (m, 2) array
        Unit vectors.
    offsets : (m,) array
        By how much the position is off along each of them [m].
    log_likelihood : float
        How well walls explain what is seen, up to a constant.
    faces : (f, 2) array
        The sensed points that belong to faces, relative to the robot [m].
    unexplained : (u, 2) array
        The sensed points that are neither a wall nor a robot, for all that the robot believes of its place [m].
    """

    directions: FloatArray
    offsets: FloatArray
    log_likelihood: float
    faces: FloatArray
    unexplained: FloatArray


NOTHING = Recognition(np.empty((0, 2)), np.empty(0), 0.0, np.empty((0, 2)), np.empty((0, 2)))


class WallMap:
    """The faces and outer corners of all known walls.

    Parameters
    ----------
    obstacles : sequence of (k, 2) array
        Simple polygons in either sense of rotation [m].
    """

    def __init__(self, obstacles: Sequence[FloatArray]) -> None:
        faces = [_faces(corners) for corners in obstacles]
        starts, along, lengths, before = (np.concatenate(parts) for parts in zip(_NO_FACES, *faces, strict=True))
        self._starts, self._along, self._lengths = starts, along, lengths
        # Counter-clockwise corners: the outside is to the right of an edge.
        self._normals = np.stack([along[:, 1], -along[:, 0]], axis=1)
        is_outer = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0] > 0.0
        self._corners = starts[is_outer]
        # Who looks at a corner as the nearest point looks back along the face before it and ahead along the next.
        self._corner_views = -before[is_outer], along[is_outer]

    def recognize(
        self, position: FloatArray, covariance: FloatArray, points: FloatArray, robots: FloatArray, unsure: FloatArray
    ) -> Recognition:
        """Return what the sensed walls say of the position.

        Parameters
        ----------
        position : (2,) array
            Own estimate [m].
        covariance : (2, 2) array
            Of the estimate [m^2].
        points : (k, 2) array
            Sensed points relative to the robot, axes of the world [m].
        robots : (n, 2) array
            Where radio neighbors are, by their own account [m].
        unsure : (n,) array
            Standard deviations of that [m].
        """
        points = points[are_no_robots(position + points, widest(covariance), robots, unsure)]
        if not len(points) or not len(self._starts):
            return NOTHING
        spots = position + points
        gaze = points / np.maximum(np.hypot(*points.T), np.finfo(np.float64).tiny)[:, None]
        offsets = spots[:, None] - self._starts
        # How far the robot must move along the normal for the point to fit.
        short = -(offsets * self._normals).sum(axis=2)
        along = (offsets * self._along).sum(axis=2)
        beyond = np.clip(along, 0.0, self._lengths) - along
        by_face = _surprise(self._normals, covariance, short) + _surprise(self._along, covariance, beyond)
        by_face[gaze @ self._normals.T > -math.cos(ASKEW)] = _NEVER
        away = self._corners - spots[:, None]
        by_corner = (away * (away @ np.linalg.inv(covariance + FIT_M**2 * np.eye(2)))).sum(axis=2)
        for views in self._corner_views:
            by_corner[gaze @ views.T < math.sin(ASKEW)] = _NEVER

        surprise = np.concatenate([by_face, by_corner, np.full((len(points), 2), _NEVER)], axis=1)
        first, second = np.partition(surprise, 1, axis=1)[:, :2].T
        log_likelihood = -0.5 * TEMPER * float(np.minimum(first, SURPRISE_MAX).sum())
        seen = np.flatnonzero((first <= SURPRISE_MAX) & (second - first >= CLEARLY))
        best = surprise[seen].argmin(axis=1)
        is_face = best < len(self._starts)
        point, face = seen[is_face], best[is_face]
        ends = beyond[point, face] != 0.0
        corners = away[seen[~is_face], best[~is_face] - len(self._starts)]
        directions = (self._normals[face], self._along[face[ends]], np.tile(np.eye(2), (len(corners), 1)))
        steps = (short[point, face], beyond[point[ends], face[ends]], corners.ravel())
        return Recognition(
            np.concatenate(directions),
            np.concatenate(steps),
            log_likelihood,
            points[point],
            points[first > SURPRISE_MAX],
        )


_NEVER = 1e9
_NO_FACES = np.empty((0, 2)), np.empty((0, 2)), np.empty(0), np.empty((0, 2))


def _faces(corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return starts (k, 2), directions (k, 2), lengths (k,) and directions before, (k, 2), counter-clockwise."""
    x, y = corners.T
    turn = float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    ordered = corners if turn > 0.0 else corners[::-1]
    steps = np.roll(ordered, -1, axis=0) - ordered
    kept = np.hypot(*steps.T) > 0.0
    ordered, steps = ordered[kept], steps[kept]
    lengths = np.hypot(*steps.T)
    along = steps / lengths[:, None]
    return ordered, along, lengths, np.roll(along, 1, axis=0)


def _surprise(directions: FloatArray, covariance: FloatArray, offsets: FloatArray) -> FloatArray:
    """Return the squares of the offsets, (k, e), over the variances of the position along the directions, (e, 2)."""
    variances = ((directions @ covariance) * directions).sum(axis=1) + FIT_M**2
    surprise: FloatArray = offsets**2 / variances
    return surprise


def are_no_robots(spots: FloatArray, sigma: float, robots: FloatArray, unsure: FloatArray) -> BoolArray:
    """Return which points are not the body of any robot that says where it is, (k,).

    Parameters
    ----------
    spots : (k, 2) array
        Where the points are by the own estimate [m].
    sigma : float
        Standard deviation of that [m].
    robots : (n, 2) array
        Where robots are, by their own account [m].
    unsure : (n,) array
        Standard deviations of that [m].
    """
    east, north = spots[:, :1] - robots[:, 0], spots[:, 1:] - robots[:, 1]
    keep_off = ROBOT_M + SIGMAS * np.hypot(sigma, unsure)
    return np.asarray((east * east + north * north > keep_off * keep_off).all(axis=1))
