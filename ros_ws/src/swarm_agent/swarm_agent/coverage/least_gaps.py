"""Descent for layouts: places move until hardly a gap is left and links hold, by damped least squares.

What a layout lacks is a sum of squares: how far each point of a cloud is outside the nearest ball, and how much too
long each edge of the tree is. Gauss-Newton steps with damping (Levenberg-Marquardt) need ten to thirty looks at the
cloud where L-BFGS, which learns the curvature from slopes, needs a hundred.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dposv

from swarm_msgs_py.partition.rounding import on_grid
from swarm_msgs_py.types import FloatArray, IntArray

LINK_WEIGHT = 10.0  # of the mean squared excess of a link against that of a gap: links must hold, gaps may remain
STEP_M, TOLERANCE_M = 5.0, 0.002  # farthest that a place moves in a step, and least [m]
DAMPING, DAMPING_MAX = 0.03, 1e6  # of the first step, and so much that steps are too short to matter
EASED, STIFFENED = 0.3, 5.0  # factors of the damping after a step that helped, and one that did not
GAIN_MIN = 0.005  # share of the cost that a step must bring for another one to be worth while

Parts = tuple[FloatArray, FloatArray, IntArray, FloatArray, FloatArray, IntArray]
"""Excess and way out of each uncovered point and whose it is; stretch, direction and number of each too long edge."""


class Gaps:
    """What places lack, for one tree and the points of a cloud that may come to be uncovered.

    Parameters
    ----------
    cloud : (m, 3) array
        [m].
    share : float
        Weight of a point's squared excess.
    radius, reach : float
        Range of covering and longest link [m].
    tails, heads : (n - 1,) int array
        Ends of the tree's edges.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - what is weighed
        self, cloud: FloatArray, share: float, radius: float, reach: float, tails: IntArray, heads: IntArray
    ) -> None:
        self._share, self._radius, self._reach = share, radius, reach
        self._tails, self._heads = tails, heads
        self._points, self._cloud = cloud, np.ascontiguousarray(cloud.T, dtype=np.float32)
        self._squares, self._step = (np.empty((len(heads) + 1, len(cloud)), dtype=np.float32) for _ in range(2))

    def cost(self, places: FloatArray) -> tuple[float, Parts]:
        """Return the cost of places (n, 3) [m^2], and the parts of it, for `model`."""
        # Places along the first axis: the least of each column is found in one sweep over long rows. Single precision
        # tells which points are far, and from whom; by how much is computed in full.
        squares, step = self._squares, self._step
        columns = places.astype(np.float32).T
        np.subtract(columns[0][:, None], self._cloud[0], out=squares)
        np.multiply(squares, squares, out=squares)
        for axis in (1, 2):
            np.subtract(columns[axis][:, None], self._cloud[axis], out=step)
            np.multiply(step, step, out=step)
            np.add(squares, step, out=squares)
        far = np.flatnonzero(squares.min(axis=0) > self._radius**2)
        owner = squares[:, far].argmin(axis=0)
        offsets = places[owner] - self._points[far]
        distances = np.sqrt(np.einsum("ij,ij->i", offsets, offsets))
        excess = distances - self._radius
        spans = places[self._tails] - places[self._heads]
        lengths = np.sqrt(np.einsum("ij,ij->i", spans, spans))
        long = np.flatnonzero(lengths > self._reach)
        stretch = lengths[long] - self._reach
        cost = self._share * float(excess @ excess) + LINK_WEIGHT * float(stretch @ stretch)
        return cost, (excess, offsets / distances[:, None], owner, stretch, spans[long] / lengths[long, None], long)

    def model(self, count: int, parts: Parts) -> tuple[FloatArray, FloatArray]:
        """Return half the cost's slope (3 n,) [m] and its Gauss-Newton Hessian (3 n, 3 n), from the parts of a cost."""
        excess, ways, owner, stretch, spans, long = parts
        slope, bend = np.empty((count, 3)), np.zeros((count, 3, count, 3))
        every, weighed = np.arange(count), self._share * ways
        for axis in range(3):
            slope[:, axis] = np.bincount(owner, excess * weighed[:, axis], count)
            for other in range(axis + 1):
                block = np.bincount(owner, weighed[:, axis] * ways[:, other], count)
                bend[every, axis, every, other] = bend[every, other, every, axis] = block
        rows, size = np.arange(len(long)), 3 * count
        pulls = np.zeros((len(long), count, 3))  # how much longer each link gets with each coordinate
        pulls[rows, self._tails[long]], pulls[rows, self._heads[long]] = spans, -spans
        flat = pulls.reshape(len(long), size)
        return (
            slope.reshape(size) + LINK_WEIGHT * (stretch @ flat),
            bend.reshape(size, size) + LINK_WEIGHT * (flat.T @ flat),
        )


def closed(gaps: Gaps, places: FloatArray, steps_max: int) -> FloatArray:
    """Return the places moved downhill, (n, 3) [m]; the first one stays.

    Parameters
    ----------
    gaps : Gaps
    places : (n, 3) array
        Start [m].
    steps_max : int
        Ends after this many steps.

    References
    ----------
    .. [1] J. Nocedal, S. J. Wright, "Numerical Optimization", 2nd ed., Springer, 2006, section 10.3.
    """
    places, damping = on_grid(places), DAMPING
    cost, parts = gaps.cost(places)
    for _ in range(steps_max):
        if cost == 0.0 or len(places) == 1:
            break
        slope, bend = gaps.model(len(places), parts)
        before = cost
        while True:
            step = _damped_step(slope[3:], bend[3:, 3:], damping)
            longest = float(np.abs(step).max())
            if longest < TOLERANCE_M or damping > DAMPING_MAX:
                return places
            step *= min(1.0, STEP_M / longest)
            moved = np.concatenate([places[:1], on_grid(places[1:] + step.reshape(-1, 3))])
            cost, parts = gaps.cost(moved)
            if cost < before:
                break
            damping *= STIFFENED
        places = moved
        damping *= EASED
        if before - cost < GAIN_MIN * before:
            break
    return places


def _damped_step(slope: FloatArray, bend: FloatArray, damping: float) -> FloatArray:
    """Return the step that solves ``(bend + damping) step = -slope``: positive definite, so by Cholesky."""
    system = bend + damping * np.eye(len(slope))
    step: FloatArray = -dposv(system, slope, overwrite_a=1)[1]
    return step
