"""Fewer changes of a long run, for a small report: what changed meanwhile is shown at the next full step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.types import BoolArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Thinned:
    """Which changes are left.

    Attributes
    ----------
    rows : (k,) int array
        Of the changes, in their order.
    frames : (k,) int array
        From when on each is shown.
    step : int
        Every how many frames there may be changes; 1 if nothing had to be left out.
    """

    rows: IntArray
    frames: IntArray
    step: int


def thinned(frames: IntArray, things: IntArray, weights: IntArray, limit: int, last: int) -> Thinned:
    """Return the changes in the smallest step, a power of two, in which their weight is within a limit.

    Of several changes of a thing in a step the last is left; it is shown at the end of the step.

    Parameters
    ----------
    frames : (n,) int array
        When each change is, ascending for each thing.
    things : (n,) int array
        What changes.
    weights : (n,) int array
        How much room each change takes.
    limit : int
        Of the weight of all together.
    last : int
        Last frame of the replay.
    """
    order = np.argsort(things, kind="stable")
    step = 1
    while True:
        shown = np.minimum(-(-frames // step) * step, last)
        is_left = np.empty(len(frames), dtype=bool)
        is_left[order] = _is_last(things[order], shown[order])
        if step > last or weights[is_left].sum() <= limit:
            rows = np.flatnonzero(is_left)
            return Thinned(rows, shown[rows], step)
        step *= 2


def _is_last(things: IntArray, frames: IntArray) -> BoolArray:
    """Return which changes no other one of the same thing follows in the same frame."""
    is_last: BoolArray = np.ones(len(frames), dtype=bool)
    is_last[:-1] = (things[1:] != things[:-1]) | (frames[1:] != frames[:-1])
    return is_last


def thinned_pairs(frames: IntArray, pairs: IntArray, is_up: BoolArray, limit: int, last: int) -> Thinned:
    """Return the same for pairs that come together and part, (n, 2): also without those that change nothing.

    Parameters
    ----------
    frames : (n,) int array
    pairs : (n, 2) int array
        Of nodes.
    is_up : (n,) bool array
        Whether they come together.
    limit : int
        Of the number of changes.
    last : int
        Last frame of the replay.
    """
    if not len(frames):
        return Thinned(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), 1)
    _, things = np.unique(pairs, axis=0, return_inverse=True)
    left = thinned(frames, things.ravel(), np.ones(len(frames), dtype=np.int64), limit, last)
    told = _is_news(things.ravel()[left.rows], is_up[left.rows])
    return Thinned(left.rows[told], left.frames[told], left.step)


def _is_news(things: IntArray, is_up: BoolArray) -> BoolArray:
    """Return which changes leave their pair in another state than it was in; before the first, all are apart."""
    order = np.argsort(things, kind="stable")
    before = np.zeros(len(things), dtype=bool)
    same = things[order][1:] == things[order][:-1]
    before[1:] = is_up[order][:-1] & same
    is_news: BoolArray = np.empty(len(things), dtype=bool)
    is_news[order] = is_up[order] != before
    return is_news
