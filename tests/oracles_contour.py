"""The thesis' sums over resampled contours (spec section 8.1), slow and obvious, for tests."""

from __future__ import annotations

import numpy as np

from swarm_msgs_py.types import FloatArray


def resampled(contour: FloatArray, spacing: float) -> tuple[FloatArray, FloatArray]:
    """Return midpoints of steps of about `spacing` along a contour, and the steps' lengths ds, (m, 2) and (m,)."""
    points, lengths = [], []
    for start, end in zip(contour, np.roll(contour, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        count = int(np.ceil(length / spacing))
        along = (np.arange(count) + 0.5) / count
        points.append(start + along[:, None] * (end - start))
        lengths.append(np.full(count, length / count))
    return np.concatenate(points), np.concatenate(lengths)


def summed_attraction(contour: FloatArray, point: FloatArray, spacing: float) -> FloatArray:
    """Sum of (z_k - z) ds, thesis eq. (3.81) with ds."""
    points, ds = resampled(contour, spacing)
    return ds @ (points - point)


def summed_repulsion(contour: FloatArray, point: FloatArray, spacing: float) -> FloatArray:
    """Sum of (z - z_k) / |z - z_k|^3 ds, thesis eq. (3.84) with ds."""
    points, ds = resampled(contour, spacing)
    away = point - points
    return (ds / np.linalg.norm(away, axis=1) ** 3) @ away


def summed_transition(contour: FloatArray, point: FloatArray, spacing: float) -> FloatArray:
    """Sum of (z_k - z) / |z_k - z| ds, thesis eq. (3.90) with ds."""
    points, ds = resampled(contour, spacing)
    away = points - point
    return (ds / np.linalg.norm(away, axis=1)) @ away


def summed_obstacle(
    outlines: tuple[FloatArray, ...], point: FloatArray, radius: float, gap_min: float, spacing: float
) -> FloatArray:
    """Sum of (z - z_k) / max(|z - z_k| - r, gap_min)^4 ds over all outlines, thesis eq. (3.93) with ds."""
    total = np.zeros(2)
    for outline in outlines:
        points, ds = resampled(outline, spacing)
        away = point - points
        total += (ds / np.maximum(np.linalg.norm(away, axis=1) - radius, gap_min) ** 4) @ away
    return total


def summed_winding_number(contour: FloatArray, point: FloatArray, spacing: float) -> float:
    """Real part of (1 / 2 pi i) times the sum of (z_{k+1} - z_k) / (z_k - z), thesis eqs. (3.51)-(3.60)."""
    points, _ = resampled(contour, spacing)
    steps = np.roll(points, -1, axis=0) - points
    away = points - point
    quotients = (steps[:, 0] + 1j * steps[:, 1]) / (away[:, 0] + 1j * away[:, 1])
    return float((quotients.sum() / (2j * np.pi)).real)
