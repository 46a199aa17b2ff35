"""Changes that are left out of long reports: what is left is right at every full step."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reports.thinning import Thinned, thinned, thinned_pairs

LAST = 20
changes = st.lists(st.tuples(st.integers(0, LAST), st.integers(0, 2)), max_size=40).map(sorted)


def state_at(frame: int, frames: np.ndarray, rows: np.ndarray, things: np.ndarray, thing: int) -> int:
    """Return the last change of a thing up to a frame, -1 before the first."""
    held = [int(row) for row, at in zip(rows, frames, strict=True) if things[row] == thing and at <= frame]
    return max(held, default=-1)


@given(changes, st.integers(1, 40))
def test_at_every_full_step_everything_is_as_it_was(found: list[tuple[int, int]], limit: int) -> None:
    frames, things = (np.array([each[axis] for each in found], dtype=np.int64) for axis in (0, 1))
    left = thinned(frames, things, np.ones(len(found), dtype=np.int64), limit, LAST)

    assert len(left.rows) <= max(limit, 2 * 3)  # the least there can be: the first frame, and the last
    for frame in (*range(0, LAST, left.step), LAST):
        for thing in range(3):
            wanted = state_at(frame, frames, np.arange(len(found)), things, thing)
            assert state_at(frame, left.frames, left.rows, things, thing) == wanted


def test_what_fits_is_left_as_it_is() -> None:
    frames = np.array([0, 3, 3, 7])
    left = thinned(frames, np.array([0, 0, 1, 0]), np.array([5, 1, 1, 1]), 8, 9)

    assert left.step == 1
    assert left.rows.tolist() == [0, 1, 2, 3]
    assert left.frames.tolist() == [0, 3, 3, 7]


def links(*found: tuple[int, int, int, bool], limit: int) -> Thinned:
    table = np.array(found)
    return thinned_pairs(table[:, 0], table[:, 1:3], table[:, 3].astype(bool), limit, LAST)


def test_a_pair_that_parts_and_meets_again_within_a_step_has_not_changed() -> None:
    left = links((0, 0, 1, True), (5, 0, 1, False), (6, 0, 1, True), (5, 1, 2, True), (6, 1, 2, False), limit=2)

    assert left.step > 1
    assert left.rows.tolist() == [0]
    assert links((0, 0, 1, True), (5, 0, 1, False), limit=2).rows.tolist() == [0, 1]
