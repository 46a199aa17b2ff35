"""Where goals are between the knots of their track: on smooth ways, in a frame that turns with the shape."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.geometry.morphing import smooth_step
from swarm_msgs_py.types import FloatArray


class Ways:
    """Goals as cubic Hermite splines over shares of the time.

    Slopes at inner knots are harmonic means of those on both sides, or zero where these have different signs, so that
    nothing overshoots: a goal never leaves the range between two knots, along x and along y. Where the shape turns,
    that is seen in a frame that turns with it, about its center, so that goals do not cut corners, however fast it is.

    Parameters
    ----------
    track : (m, n, 2) array
        Goals at equal shares of the time, m >= 2 [m].
    centers : tuple of (2,) array
        Of the shape at the beginning and at the end [m].
    rotation_rad : float
        By how much it turns on the way, counter-clockwise [rad].

    References
    ----------
    .. [1] F. N. Fritsch, J. Butland, "A method for constructing local monotone piecewise cubic interpolants", SIAM
       Journal on Scientific and Statistical Computing 5(2), 1984.
    """

    def __init__(self, track: FloatArray, centers: tuple[FloatArray, FloatArray], rotation_rad: float) -> None:
        self._rotation = rotation_rad
        self._begin, self._way = centers[0], centers[1] - centers[0]
        if rotation_rad:
            shares = np.linspace(0.0, 1.0, len(track)).tolist()
            own = [
                self._spun(places - self._center(s), -self._angle(s)) for s, places in zip(shares, track, strict=True)
            ]
            track = np.stack(own)
        self._track = track
        self._rises = np.diff(track, axis=0)
        before, after = self._rises[:-1], self._rises[1:]
        product, total = before * after, before + after
        self._slopes = np.zeros_like(track)  # per interval between knots
        np.divide(2.0 * product, total, out=self._slopes[1:-1], where=product > 0.0)

    def goals(self, share: float) -> FloatArray:
        """Return the goals after a share of the time, (n, 2) [m]."""
        goals = self._own(share)
        if self._rotation:
            goals = self._center(share) + self._spun(goals, self._angle(share))
        goals.flags.writeable = False
        return goals

    def rates(self, share: float) -> FloatArray:
        """Return the change of the goals per share of the time, (n, 2) [m]."""
        knot, t = self._place(share)
        first, last, rise = self._slopes[knot], self._slopes[knot + 1], self._rises[knot]
        bend = 2.0 * (3.0 * rise - 2.0 * first - last) + 3.0 * t * (first + last - 2.0 * rise)
        rates: FloatArray = len(self._rises) * (first + t * bend)
        if not self._rotation:
            return rates
        hurry = 6.0 * share * (1.0 - share)  # slope of the smooth step
        arms = self._own(share)
        spin = self._rotation * hurry * np.column_stack([-arms[:, 1], arms[:, 0]])
        return hurry * self._way + self._spun(rates + spin, self._angle(share))

    def _own(self, share: float) -> FloatArray:
        """Return the goals in the frame that turns."""
        knot, t = self._place(share)
        first, last, rise = self._slopes[knot], self._slopes[knot + 1], self._rises[knot]
        own: FloatArray = self._track[knot] + t * (
            first + t * ((3.0 * rise - 2.0 * first - last) + t * (first + last - 2.0 * rise))
        )
        return own

    def _place(self, share: float) -> tuple[int, float]:
        """Return the knot before a share of the time, and how far it is from there to the next one, 0 to 1."""
        place = share * len(self._rises)
        knot = min(int(place), len(self._rises) - 1)
        return knot, place - knot

    def _center(self, share: float) -> FloatArray:
        center: FloatArray = self._begin + smooth_step(share) * self._way
        return center

    def _angle(self, share: float) -> float:
        return smooth_step(share) * self._rotation

    @staticmethod
    def _spun(points: FloatArray, angle: float) -> FloatArray:
        (x, y), cosine, sine = points.T, np.cos(angle), np.sin(angle)
        return np.column_stack([cosine * x - sine * y, sine * x + cosine * y])
