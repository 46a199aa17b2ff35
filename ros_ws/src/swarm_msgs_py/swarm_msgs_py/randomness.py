"""Named random streams: a new consumer never shifts the numbers of another."""

from __future__ import annotations

import zlib

import numpy as np


def rng_for(seed: int, *name: str | int) -> np.random.Generator:
    """Return the random stream that belongs to `name` under `seed`.

    Parameters
    ----------
    seed : int
        Seed of the run, >= 0.
    *name : str or int
        What the numbers are for, e.g. ``rng_for(seed, "ranging", 7)``.
    """
    words = [zlib.crc32(part.encode()) if isinstance(part, str) else part for part in name]
    return np.random.default_rng(np.random.SeedSequence([seed, *words]))
