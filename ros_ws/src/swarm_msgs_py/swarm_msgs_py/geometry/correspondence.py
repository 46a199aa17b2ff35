"""Which point of one contour becomes which point of another.

Of all ways to run around two contours together, the best one bends and stretches least. Where pieces of both are the
same they are matched exactly, so that what does not change about a shape does not move.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.types import FloatArray, IntArray

COARSE = 48  # points in the search for where to begin
FINE = 96  # points, about, between which the match is found, if there are not more corners
PIECES_MAX = 64  # of one edge; a target may be far longer than the start
CORNERS_MAX = 512  # contours with more are resampled: the search takes as long as the product of both numbers
NEARBY = 2.0  # coarse points around the best beginning, between which the fine search begins
STRETCHES = ((1, 1), (1, 2), (2, 1), (2, 3), (3, 2), (1, 3), (3, 1), (1, 4), (4, 1))  # pieces of each that may match
COLLAPSE = 2.0  # cost per length of a piece that becomes a point: what `_stretching` says of it
UNIT = 2.0**30  # costs are whole numbers of this part, so that sums are exact, and ties the same on all processors


def matched(start: FloatArray, target: FloatArray, collapse: float = COLLAPSE) -> tuple[FloatArray, FloatArray]:
    """Return points of two contours that belong together, in order; among them are all corners of both.

    A piece of one may belong to a single point of the other: where a shape parts in two, the sides between the parts
    come out of one point.

    Parameters
    ----------
    start, target : (k, 2), (m, 2) array
        Simple contours, counter-clockwise; where they are does not count, how they are turned does [m].
    collapse : float
        Cost per length of a piece that becomes a point, or comes out of one; the less, the fewer are its neighbors that
        take part in it.

    Returns
    -------
    (p, 2) array, (p, 2) array
        Points of the start and of the target [m].

    References
    ----------
    .. [1] A. Srivastava et al., "Shape analysis of elastic curves in Euclidean spaces", IEEE Transactions on Pattern
       Analysis and Machine Intelligence 33(7), 2011; there, too, the match is found by dynamic programming.
    """
    growth = (signed_area(target) / signed_area(start)) ** 0.5
    # A shape as a whole that grows, or a part of it that changes: whichever is the smaller change.
    candidates = [_Match(start, target, scale, collapse) for scale in ((1.0, growth) if growth != 1.0 else (1.0,))]
    return min(candidates, key=lambda match: match.cost).points()


class _Match:
    """The best match of a contour with another one, after that has been scaled.

    Parameters
    ----------
    start, target : (k, 2), (m, 2) array
        [m].
    scale : float
        By how much larger the target is held to be.
    collapse : float
        Cost per length of a piece that becomes a point.

    Attributes
    ----------
    cost : int
        Of the match.
    """

    def __init__(self, start: FloatArray, target: FloatArray, scale: float, collapse: float) -> None:
        size = signed_area(start) ** 0.5
        self._scales = size, size * scale
        contours = start / self._scales[0], target / self._scales[1]
        piece = _lengths_before(contours[0])[-1] / FINE
        self._one, self._other = (_refined(contour, piece) for contour in contours)
        coarse = resampled(self._one, COARSE), resampled(self._other, COARSE)
        begin = _Elastic(*coarse, np.arange(COARSE), collapse).best_begin()
        lengths = _lengths_before(self._other)
        away = COARSE * lengths[:-1] / lengths[-1] - begin
        apart = np.abs((away + 0.5 * COARSE) % COARSE - 0.5 * COARSE)
        nearby = np.flatnonzero(apart <= max(NEARBY, float(apart.min())))
        elastic = _Elastic(self._one, self._other, nearby, collapse)
        self._path, self.cost = elastic.path(), elastic.least

    def points(self) -> tuple[FloatArray, FloatArray]:
        """Return the points that belong together, (p, 2) each [m]."""
        rows = _with_skipped(self._path, _lengths_before(self._one), _lengths_before(self._other))
        one, other = (_at_lengths(c, rows[:, k]) for k, c in enumerate((self._one, self._other)))
        return self._scales[0] * one, self._scales[1] * other


def resampled(contour: FloatArray, count: int) -> FloatArray:
    """Return `count` points at equal distances along a (k, 2) contour, from its first point on."""
    total = _lengths_before(contour)[-1]
    return _at_lengths(contour, np.arange(count) * (total / count))


class _Elastic:
    """Dynamic program over two polygons: the cheapest way from vertex to vertex around both.

    Parameters
    ----------
    one, other : (n, 2), (m, 2) array
    begins : (c,) int array
        Vertices of the other to which the first vertex of the one may belong.
    collapse : float
        Cost per length of an edge that becomes a point.
    """

    def __init__(self, one: FloatArray, other: FloatArray, begins: IntArray, collapse: float) -> None:
        self._sizes = len(one), len(other)
        self._begins = begins
        columns = (begins[:, None] + np.arange(len(other) + 1)) % len(other)
        self._stretches = {
            (a, b): _stretching(one, other, a, b)[:, columns[:, : len(other) + 1 - b]] for a, b in STRETCHES
        }
        self._ones = _whole(collapse * np.linalg.norm(np.roll(one, -1, axis=0) - one, axis=1))
        steps = _whole(collapse * np.linalg.norm(np.roll(other, -1, axis=0) - other, axis=1))
        # What it costs to let the other's vertices up to here belong to one vertex.
        self._others = np.zeros(columns.shape, dtype=np.int64)
        self._others[:, 1:] = np.cumsum(steps[columns[:, :-1]], axis=1)
        self._costs = self._solved()

    @property
    def least(self) -> int:
        """Cost of the cheapest way."""
        return int(self._costs[-1, :, -1].min())

    def best_begin(self) -> int:
        """Return to which vertex of the other the first of the one belongs in the cheapest way."""
        return int(self._begins[np.argmin(self._costs[-1, :, -1])])

    def path(self) -> IntArray:
        """Return the cheapest way: vertices of both, running on beyond their numbers, (p, 2)."""
        chosen = int(np.argmin(self._costs[-1, :, -1]))
        costs = self._costs[:, chosen]
        here = self._sizes
        path = [here]
        while here != (0, 0):
            here = self._before(costs, chosen, *here)
            path.append(here)
        begin = int(self._begins[chosen])
        return np.array([(i, begin + j) for i, j in reversed(path)])

    def _solved(self) -> IntArray:
        """Return the least cost of every pair of vertices, for each beginning, (n + 1, c, m + 1)."""
        n, m = self._sizes
        costs = np.zeros((n + 1, len(self._begins), m + 1), dtype=np.int64)
        costs[0] = self._others
        for i in range(1, n + 1):
            least = costs[i - 1] + self._ones[i - 1]
            for (a, b), stretch in self._stretches.items():
                if a <= i:
                    np.minimum(least[:, b:], costs[i - a, :, : m + 1 - b] + stretch[i - a], out=least[:, b:])
            costs[i] = np.minimum.accumulate(least - self._others, axis=1) + self._others
        return costs

    def _before(self, costs: IntArray, chosen: int, i: int, j: int) -> tuple[int, int]:
        """Return from where the cheapest way came to a pair; sums are exact, so equality tells."""
        for (a, b), stretch in self._stretches.items():
            if a <= i and b <= j and costs[i - a, j - b] + stretch[i - a, chosen, j - b] == costs[i, j]:
                return i - a, j - b
        if i and costs[i - 1, j] + self._ones[i - 1] == costs[i, j]:
            return i - 1, j
        return i, j - 1


def _stretching(one: FloatArray, other: FloatArray, a: int, b: int) -> IntArray:
    """Return what it costs that `a` edges from each vertex of the one become `b` edges of the other, (n, m).

    It is the square of the change of the chord per mean length of both.
    """
    first, second = np.roll(one, -a, axis=0) - one, np.roll(other, -b, axis=0) - other
    change = first[:, None] - second
    mean = 0.5 * (np.linalg.norm(first, axis=1)[:, None] + np.linalg.norm(second, axis=1))
    return _whole((change**2).sum(axis=2) / np.maximum(mean, 1.0 / UNIT))


def _whole(costs: FloatArray) -> IntArray:
    whole: IntArray = np.rint(UNIT * costs).astype(np.int64)
    return whole


def _with_skipped(path: IntArray, ones: FloatArray, others: FloatArray) -> FloatArray:
    """Return a path as lengths along both contours, with a stop at every vertex that it skips, (p, 2)."""
    stops = []
    for (i, j), (k, h) in pairwise(path.tolist()):
        (s, t), (u, v) = (_running(ones, i), _running(others, j)), (_running(ones, k), _running(others, h))
        shares = {0.0}
        shares.update((_running(ones, skipped) - s) / (u - s) for skipped in range(i + 1, k))
        shares.update((_running(others, skipped) - t) / (v - t) for skipped in range(j + 1, h))
        stops += [(s + share * (u - s), t + share * (v - t)) for share in sorted(shares)]
    return np.array(stops)


def _running(lengths: FloatArray, vertex: int) -> float:
    """Return the length along a contour to a vertex that may be beyond the end of its first round."""
    rounds, place = divmod(vertex, len(lengths) - 1)
    return float(rounds * lengths[-1] + lengths[place])


def _lengths_before(contour: FloatArray) -> FloatArray:
    """Return how far along a contour each vertex is, and all of its length, (k + 1,)."""
    steps = np.roll(contour, -1, axis=0) - contour
    return np.concatenate([[0.0], np.cumsum(np.sqrt((steps * steps).sum(axis=1)))])


def _at_lengths(contour: FloatArray, lengths: FloatArray) -> FloatArray:
    before = _lengths_before(contour)
    closed = np.concatenate([contour, contour[:1]])
    places = lengths % before[-1]
    return np.column_stack([np.interp(places, before, closed[:, axis]) for axis in range(2)])


def _refined(contour: FloatArray, piece: float) -> FloatArray:
    """Return a contour with points on its longer edges, about `piece` apart; equal edges are divided alike."""
    if len(contour) > CORNERS_MAX:
        return resampled(contour, CORNERS_MAX)
    following = np.roll(contour, -1, axis=0)
    lengths = np.sqrt(((following - contour) ** 2).sum(axis=1))
    pieces = np.clip(np.rint(lengths / piece), 1, PIECES_MAX).astype(np.int64)
    first = np.repeat(np.arange(len(contour)), pieces)
    share = (np.arange(len(first)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[first]
    points: FloatArray = contour[first] + share[:, None] * (following - contour)[first]
    return points
