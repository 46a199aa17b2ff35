"""Which point of one contour becomes which point of another.

Of all ways to run around two contours together, the best one bends and stretches least. Where pieces of both are the
same they are matched exactly, so that what does not change about a shape does not move.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np

from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.types import FloatArray, IntArray

COARSE = 48  # points in the search for where to begin
FINE = 96  # points, about, between which the match is found, if there are not more corners
CORNERS_MAX = 512
"""Contours with more corners are resampled; those of plans may not have more."""
KEPT_MAX = 128  # corners that take part in the search, those that stand out most; it takes as long as their product
VERTICES_MAX = 192  # of both contours in the search, with the points put between their corners
NEARBY = 2.0  # coarse points around the best beginning, between which the fine search begins
BEGINS_MAX = 24  # of them; corners may be crowded there
STRETCHES = ((1, 1), (1, 2), (2, 1), (2, 3), (3, 2), (1, 3), (3, 1), (1, 4), (4, 1))  # pieces of each that may match
COLLAPSE = 2.0  # cost per length of a piece that becomes a point: what `_stretching` says of it
UNIT = 2.0**30  # costs are whole numbers of this part, so that sums are exact, and ties the same on all processors
FINER = 1.1  # factor by which pieces grow until there are few enough
DECIMALS = 6  # [m]; of places when corners are chosen, so that a shape that is shifted keeps the same ones
SAME_PLACE = 1e-9  # share of the size; places along a contour that are nearer to each other are one


def matched(start: FloatArray, target: FloatArray, collapse: float = COLLAPSE) -> tuple[FloatArray, FloatArray]:
    """Return points of two contours that belong together, in order; among them are all corners of both.

    A piece of one may belong to a single point of the other: where a shape parts in two, the sides between the parts
    come out of one point. Of contours with more than `KEPT_MAX` corners the least go along with their neighbors: time
    and memory are bounded, whatever the contours, to a few tenths of a second and 50 MB.

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
    start, target = (c if len(c) <= CORNERS_MAX else resampled(c, CORNERS_MAX) for c in (start, target))
    growth = (signed_area(target) / signed_area(start)) ** 0.5
    # A shape as a whole that grows, or a part of it that changes: whichever is the smaller change.
    candidates = [_Match(start, target, scale, collapse) for scale in ((1.0, growth) if growth != 1.0 else (1.0,))]
    return min(candidates, key=lambda match: match.cost).points()


@dataclass(frozen=True, slots=True)
class _Outline:
    """A contour in the search.

    Attributes
    ----------
    contour : (k, 2) array
        All of it.
    places : (n,) array
        How far along it the vertices are between which the match is found, ascending.
    vertices : (n, 2) array
        On straight lines between those corners that stand out.
    """

    contour: FloatArray
    places: FloatArray
    vertices: FloatArray

    @property
    def length(self) -> float:
        """Length of the contour."""
        return float(_lengths_before(self.contour)[-1])

    def running(self, vertices: IntArray) -> FloatArray:
        """Return how far along the contour vertices are that may be beyond the end of its first round."""
        rounds, places = np.divmod(vertices, len(self.places))
        running: FloatArray = rounds * self.length + self.places[places]
        return running

    def stops(self) -> FloatArray:
        """Return how far along three rounds of the contour its corners and vertices are."""
        stops = np.concatenate([self.places, _lengths_before(self.contour)[:-1]])
        return np.concatenate([stops, stops + self.length, stops + 2.0 * self.length])


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
        kept = [_standing_out(contour, KEPT_MAX) for contour in (start, target)]
        self._one, self._other = _refined((start / self._scales[0], target / self._scales[1]), kept)
        coarse = resampled(self._one.contour, COARSE), resampled(self._other.contour, COARSE)
        begin = _Elastic(*coarse, np.arange(COARSE), collapse).best_begin()
        first = self._one.places[0] / self._one.length
        away = COARSE * (self._other.places / self._other.length - first) - begin
        apart = np.abs((away + 0.5 * COARSE) % COARSE - 0.5 * COARSE)
        nearby = np.flatnonzero(apart <= max(NEARBY, float(apart.min())))
        nearest = np.sort(nearby[np.argsort(apart[nearby], kind="stable")[:BEGINS_MAX]])
        elastic = _Elastic(self._one.vertices, self._other.vertices, nearest, collapse)
        self._path, self.cost = elastic.path(), elastic.least

    def points(self) -> tuple[FloatArray, FloatArray]:
        """Return the points that belong together, (p, 2) each [m]."""
        path = np.column_stack([self._one.running(self._path[:, 0]), self._other.running(self._path[:, 1])])
        rows = _with_skipped(path, self._one.stops(), self._other.stops())
        one, other = (_at_lengths(c.contour, rows[:, k]) for k, c in enumerate((self._one, self._other)))
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
        # Vertices of the other as they come from each beginning, (c, m + 1).
        self._columns = columns = (begins[:, None] + np.arange(len(other) + 1)) % len(other)
        self._stretches = {(a, b): _stretching(one, other, a, b) for a, b in STRETCHES}
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
                    ways = costs[i - a, :, : m + 1 - b] + stretch[i - a][self._columns[:, : m + 1 - b]]
                    np.minimum(least[:, b:], ways, out=least[:, b:])
            costs[i] = np.minimum.accumulate(least - self._others, axis=1) + self._others
        return costs

    def _before(self, costs: IntArray, chosen: int, i: int, j: int) -> tuple[int, int]:
        """Return from where the cheapest way came to a pair; sums are exact, so equality tells."""
        for (a, b), stretch in self._stretches.items():
            if a <= i and b <= j:
                way = costs[i - a, j - b] + stretch[i - a, self._columns[chosen, j - b]]
                if way == costs[i, j]:
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


def _with_skipped(path: FloatArray, ones: FloatArray, others: FloatArray) -> FloatArray:
    """Return a path of lengths along both contours, but for its end, with all stops of both that it skips, (p, 2)."""
    parts = [path[:-1]]
    for axis, stops in enumerate((ones, others)):
        known = path[:, axis]
        after = np.clip(np.searchsorted(known, stops), 1, len(known) - 1)
        is_new = np.minimum(np.abs(stops - known[after - 1]), np.abs(known[after] - stops)) > SAME_PLACE
        skipped = stops[is_new & (stops > known[0]) & (stops < known[-1])]
        partners = np.interp(skipped, known, path[:, 1 - axis])
        parts.append(np.column_stack([skipped, partners] if axis == 0 else [partners, skipped]))
    rows = np.concatenate(parts)
    rows = rows[np.lexsort((rows[:, 1], rows[:, 0]))]
    steps = np.diff(rows, axis=0, prepend=rows[:1] - 1.0).max(axis=1)
    distinct: FloatArray = rows[steps > SAME_PLACE]
    return distinct


def _lengths_before(contour: FloatArray) -> FloatArray:
    """Return how far along a contour each vertex is, and all of its length, (k + 1,)."""
    steps = np.roll(contour, -1, axis=0) - contour
    return np.concatenate([[0.0], np.cumsum(np.sqrt((steps * steps).sum(axis=1)))])


def _at_lengths(contour: FloatArray, lengths: FloatArray) -> FloatArray:
    before = _lengths_before(contour)
    closed = np.concatenate([contour, contour[:1]])
    places = lengths % before[-1]
    return np.column_stack([np.interp(places, before, closed[:, axis]) for axis in range(2)])


def _standing_out(contour: FloatArray, count: int) -> IntArray:
    """Return which corners of a contour are left when the least ones are left out one after the other, ascending.

    The least one spans the smallest triangle with its neighbors.

    References
    ----------
    .. [1] M. Visvalingam, J. D. Whyatt, "Line generalisation by repeated elimination of points", The Cartographic
       Journal 30(1), 1993.
    """
    total = len(contour)
    if total <= count:
        return np.arange(total)
    points = (contour - contour[0]).round(DECIMALS).tolist()
    before, after = [(k - 1) % total for k in range(total)], [(k + 1) % total for k in range(total)]

    def size(corner: int) -> float:
        (a, b), (c, d), (e, f) = points[before[corner]], points[corner], points[after[corner]]
        return float(round(abs((c - a) * (f - b) - (e - a) * (d - b)), DECIMALS))

    sizes = [size(corner) for corner in range(total)]
    queue = [(its, corner) for corner, its in enumerate(sizes)]
    heapify(queue)
    out: set[int] = set()
    while len(out) < total - count:
        its, corner = heappop(queue)
        if corner in out or its != sizes[corner]:
            continue
        out.add(corner)
        left, right = before[corner], after[corner]
        after[left], before[right] = right, left
        for neighbor in (left, right):
            sizes[neighbor] = size(neighbor)
            heappush(queue, (sizes[neighbor], neighbor))
    return np.array([corner for corner in range(total) if corner not in out])


def _refined(contours: tuple[FloatArray, FloatArray], kept: list[IntArray]) -> tuple[_Outline, _Outline]:
    """Return both contours with points between the corners that are kept; equal edges of both are divided alike."""
    polygons = [contour[corners] for contour, corners in zip(contours, kept, strict=True)]
    edges = [np.sqrt(((np.roll(p, -1, axis=0) - p) ** 2).sum(axis=1)) for p in polygons]
    piece = _lengths_before(contours[0])[-1] / FINE
    while True:
        pieces = [np.maximum(np.rint(lengths / piece), 1.0) for lengths in edges]
        if max(float(numbers.sum()) for numbers in pieces) <= VERTICES_MAX:
            break
        piece *= FINER
    one, other = (
        _outline(contour, corners, numbers.astype(np.int64))
        for contour, corners, numbers in zip(contours, kept, pieces, strict=True)
    )
    return one, other


def _outline(contour: FloatArray, kept: IntArray, pieces: IntArray) -> _Outline:
    """Return a contour whose edges between the corners that are kept are divided into these numbers of pieces."""
    lengths = _lengths_before(contour)
    corners, places = contour[kept], lengths[kept]
    first = np.repeat(np.arange(len(kept)), pieces)
    share = (np.arange(len(first)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[first]
    ways, steps = np.roll(corners, -1, axis=0) - corners, np.append(places[1:], places[0] + lengths[-1]) - places
    vertices = corners[first] + share[:, None] * ways[first]
    return _Outline(contour, places[first] + share * steps[first], vertices)
