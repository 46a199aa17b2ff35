"""Layouts for few robots: places that cover a shape and stay linked, found by descent from a greedy start."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.distance import cdist

from swarm_agent.coverage.layout_tree import short_edges
from swarm_agent.coverage.least_gaps import Gaps, closed
from swarm_msgs_py.geometry.solids.sampling import interior_points
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.types import BoolArray, FloatArray

STEPS = 25  # of a descent until the tree is looked at anew
BANDS = (0.8, 0.9)  # of the range, a descent each: points deeper inside a ball are not uncovered by it
BATCH, ENOUGH = 5000, 8  # judges at a time; so many that are missed tell enough
LEARNED_MAX = 100  # judges that join the cloud at a time


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
        Fresh points of the shape by which a result is judged.
    radius, reach : float
        Range of covering and longest link, both with a little held back for the search [m].
    radius_max, link_max : float
        The same as they are [m].
    missed_max : float
        Share of the judges that may stay uncovered.
    """

    cloud: FloatArray
    leader: FloatArray
    solid: Solid
    judges: int
    radius: float
    reach: float
    radius_max: float
    link_max: float
    missed_max: float
    power: float

    def judged(self, places: FloatArray, rng: np.random.Generator) -> tuple[float, FloatArray]:
        """Return which share of fresh judges `places` leave uncovered, and the judges to learn from, (k, 3) [m].

        The same judges would be learned by heart. There are fewer of them where a part tells enough. To be learned from
        are those that are outside the range of the search already: around each gap there are several.
        """
        outside, missed, count = list[FloatArray](), 0, 0
        while count < self.judges and missed <= ENOUGH:
            judges = interior_points(self.solid, min(BATCH, self.judges - count), rng)
            squares = cdist(places, judges, "sqeuclidean").min(axis=0)
            outside.append(judges[squares > self.radius**2])
            missed += int(np.count_nonzero(squares > self.radius_max**2))
            count += len(judges)
        return missed / count, np.concatenate(outside)[:LEARNED_MAX]


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
    for band in BANDS:
        tails, heads = short_edges(places, task.power)
        is_deep = cdist(places, task.cloud, "sqeuclidean").min(axis=0) <= (band * task.radius) ** 2
        share = len(places) / len(task.cloud)
        gaps = Gaps(task.cloud[~is_deep], share, task.radius, task.reach, tails, heads)
        places = closed(gaps, places, STEPS)
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
    best, least = places, np.inf
    while True:
        places = descended(task, places)
        missed, outside = task.judged(places, rng)
        is_linked = _longest(places, task.power) <= task.link_max
        if missed <= task.missed_max and is_linked:
            return places, task
        task = replace(task, cloud=np.concatenate([task.cloud, outside]))
        if missed < least and is_linked:
            best, least = places, missed
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
