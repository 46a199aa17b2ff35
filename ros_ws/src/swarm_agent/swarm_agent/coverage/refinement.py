"""Layouts for few robots: places that cover a shape and stay linked, found by descent from a greedy start."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from swarm_agent.coverage.layout_tree import short_edges
from swarm_msgs_py.geometry.solids.sampling import interior_points
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray

LINK_WEIGHT = 10.0  # of the mean squared excess of a link against that of a gap: links must hold, gaps may remain
STEPS = 50  # of the descent until the tree is looked at anew
STEP_M, TOLERANCE_M = 5.0, 0.002  # farthest that a place moves in a step of the descent, and least [m]
DEEP = 0.7  # of the range: points this deep inside a ball are not uncovered by one descent
SCALE = 0.05  # of the cost: makes its slope a sensible first step [m]
ROUNDS = 3  # trees per descent
MISSED_MAX = 50  # judges that join the cloud at a time


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """What a layout must do.

    Attributes
    ----------
    cloud : (m, 3) array
        Points to be covered [m].
    leader : (3,) array
        Place that cannot be chosen [m].
    solid : Solid
        Shape that the cloud was drawn from.
    judges : int
        Fresh points of the shape by which a result is judged, of which at most `missed_max` may stay uncovered.
    radius, reach : float
        Range of covering and longest link, both with a little held back for the search [m].
    radius_max, link_max : float
        The same as they are [m].
    missed_max : int
    """

    cloud: FloatArray
    leader: FloatArray
    solid: Solid
    judges: int
    radius: float
    reach: float
    radius_max: float
    link_max: float
    missed_max: int
    power: float

    def missed(self, places: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return which of fresh judges `places` leave uncovered, (k, 3) [m]; the same would be learned by heart."""
        judges = interior_points(self.solid, self.judges, rng)
        missed: FloatArray = judges[cKDTree(places).query(judges)[0] > self.radius_max]
        return missed


def greedy(task: Task, candidates: FloatArray, robots_max: int) -> FloatArray:
    """Return places, each of which covers most of what is left of the cloud among those in reach, leader first.

    Parameters
    ----------
    task : Task
    candidates : (k, 3) array
        Places to choose from [m].
    robots_max : int
        Stop at this many.

    Returns
    -------
    (n, 3) array
        [m].
    """
    covers = (cdist(candidates, task.cloud) <= task.radius).astype(np.float32)
    left = (cdist(task.leader[None], task.cloud)[0] > task.radius).astype(np.float32)
    in_reach = cdist(candidates, task.leader[None])[:, 0] <= task.reach
    places = [task.leader]
    while left.any() and len(places) < robots_max:
        gains = np.where(in_reach, covers @ left, -1.0)
        best = int(np.argmax(gains))
        if gains[best] <= 0.0:  # out of reach of every candidate: a relay on the way to the nearest gap
            target = task.cloud[left > 0.0]
            distances = cdist(np.array(places), target)
            near, far = np.unravel_index(int(distances.argmin()), distances.shape)
            step = min(task.reach / float(distances[near, far]), 1.0)
            place = places[int(near)] + step * (target[far] - places[int(near)])
            left = np.where(cdist(place[None], task.cloud)[0] <= task.radius, np.float32(0.0), left)
        else:
            place = candidates[best]
            left = left * (1.0 - covers[best])
        places.append(place)
        in_reach |= cdist(candidates, place[None])[:, 0] <= task.reach
    return np.array(places)


def without_a_hardly_needed(task: Task, places: FloatArray, rank: int) -> FloatArray:
    """Return the places less one follower: of rank 0, the one that covers the fewest points alone."""
    covers: BoolArray = cdist(task.cloud, places) <= task.radius
    alone = covers[covers.sum(axis=1) == 1].sum(axis=0)
    alone[0] = len(task.cloud) + 1  # the leader stays
    return np.delete(places, int(np.argsort(alone, kind="stable")[rank]), axis=0)


def descended(task: Task, places: FloatArray) -> FloatArray:
    """Return the places moved downhill: gaps of the cloud and too long links, squared, as small as they get nearby."""
    for _ in range(ROUNDS):
        tails, heads = short_edges(places, task.power)
        deep = cdist(task.cloud, places, "sqeuclidean").min(axis=1) <= (DEEP * task.radius) ** 2
        slope = _Slope(task, task.cloud[~deep], tails, heads)
        followers = minimize(slope, places[1:], step_max=STEP_M, tolerance=TOLERANCE_M, steps_max=STEPS)
        places = np.concatenate([task.leader[None], followers])
    return places


def fitted(
    task: Task, places: FloatArray, share: float, kicks: int, rng: np.random.Generator
) -> tuple[FloatArray | None, Task]:
    """Return linked places that leave hardly a gap, or None if the search finds none, and the task as it became.

    Judges that a result leaves uncovered join the cloud, so that no gap hides between its points. A descent that
    does not lessen their number is followed by one from the best places so far, shaken.

    Parameters
    ----------
    task : Task
    places : (n, 3) array
        Start, the leader first [m].
    share : float
        Standard deviation of a kick, as a share of the range of covering.
    kicks : int
        How many descents may be in vain.
    rng : Generator
    """
    best, fewest = places, task.judges + 1
    while True:
        places = descended(task, places)
        missed = task.missed(places, rng)
        is_linked = _longest(places, task.power) <= task.link_max
        if len(missed) <= task.missed_max and is_linked:
            return places, task
        task = replace(task, cloud=np.concatenate([task.cloud, missed[:MISSED_MAX]]))
        if len(missed) < fewest and is_linked:
            best, fewest = places, len(missed)
            continue
        kicks -= 1
        if kicks < 0:
            return None, task
        if kicks % 2:  # the other half of them: the judges that joined may be all that was missing
            kick = share * task.radius * rng.normal(size=best.shape)
            kick[0] = 0.0
            places = best + kick


def _longest(places: FloatArray, power: float) -> float:
    """Return the longest edge of the tree [m]."""
    tails, heads = short_edges(places, power)
    return float(np.linalg.norm(places[tails] - places[heads], axis=1).max(initial=0.0))


class _Slope:
    """The cost of places and its slope, for one tree and the points of the cloud that are not deep inside a ball.

    Parameters
    ----------
    task : Task
    cloud : (m, 3) array
        Points that the places may come to leave uncovered [m].
    tails, heads : (n - 1,) int array
        Ends of the tree's edges.
    """

    def __init__(self, task: Task, cloud: FloatArray, tails: IntArray, heads: IntArray) -> None:
        self._task, self._tails, self._heads = task, tails, heads
        self._points, self._cloud = cloud, np.ascontiguousarray(cloud.T, dtype=np.float32)
        self._squares, self._step = (np.empty((len(heads) + 1, len(cloud)), dtype=np.float32) for _ in range(2))

    def __call__(self, followers: FloatArray) -> tuple[float, FloatArray]:
        """Return the cost of the leader and followers (n - 1, 3) [m], and its slope at the followers, (n - 1, 3)."""
        task, places = self._task, np.concatenate([self._task.leader[None], followers])
        count = len(places)
        # Places along the first axis: the least of each column is found in one sweep over long rows. Single precision
        # tells which points are far, and from whom; by how much is computed in full.
        squares, step = self._squares, self._step
        squares[:] = 0.0
        for axis, column in enumerate(places.astype(np.float32).T):
            np.subtract(column[:, None], self._cloud[axis], out=step)
            np.multiply(step, step, out=step)
            np.add(squares, step, out=squares)
        far = np.flatnonzero(squares.min(axis=0) > task.radius**2)
        owner = squares[:, far].argmin(axis=0)
        offsets = places[owner] - self._points[far]
        distances = np.sqrt(np.einsum("ij,ij->i", offsets, offsets))
        excess = distances - task.radius
        share = count / len(task.cloud)
        pull = offsets * (2.0 * share * excess / distances)[:, None]
        slope = np.stack([np.bincount(owner, pull[:, axis], count) for axis in range(3)], axis=1)
        cost = share * float(excess @ excess)

        spans = places[self._tails] - places[self._heads]
        lengths = np.sqrt(np.einsum("ij,ij->i", spans, spans))
        stretch = np.maximum(lengths - task.reach, 0.0)
        if stretch.any():
            cost += LINK_WEIGHT * float(stretch @ stretch)
            tension = spans * (2.0 * LINK_WEIGHT * stretch / np.maximum(lengths, 1e-9))[:, None]
            np.add.at(slope, self._tails, tension)
            np.subtract.at(slope, self._heads, tension)
        downhill: FloatArray = (SCALE * slope[1:]).astype(np.float64)
        return SCALE * cost, downhill
