"""Numbers in few characters: arrays as little-endian integers in base64, for the report's JavaScript to unpack."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

ABSENT = -32768
"""Stands for NaN."""

LARGEST = 32767


def packed(values: np.ndarray, step: float) -> dict[str, Any]:
    """Return an array of real numbers rounded to multiples of `step`, two bytes each; coarser where they do not fit.

    Parameters
    ----------
    values : array
        Of any shape; NaN stays NaN.
    step : float
        Wanted resolution, in the unit of the values.
    """
    finite = values[np.isfinite(values)]
    middle = 0.5 * float(finite.min() + finite.max()) if finite.size else 0.0
    reach = float(np.abs(finite - middle).max()) if finite.size else 0.0
    scale = max(step, reach / LARGEST)
    rounded = np.where(np.isfinite(values), np.rint((np.nan_to_num(values) - middle) / scale), ABSENT)
    clipped = np.clip(rounded, ABSENT, LARGEST)
    return {**_encoded(clipped, "<i2"), "scale": scale, "middle": middle}


def packed_whole(values: np.ndarray) -> dict[str, Any]:
    """Return an array of whole numbers, in the fewest bytes each that hold all of them."""
    largest = int(np.abs(values.astype(np.int64)).max()) if values.size else 0
    kind = "<i1" if largest < 2**7 else "<i2" if largest < 2**15 else "<i4"
    return _encoded(values, kind)


def _encoded(values: np.ndarray, kind: str) -> dict[str, Any]:
    data = base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")
    return {"kind": kind[1:], "shape": list(values.shape), "data": data}
