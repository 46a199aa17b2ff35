"""When the swarm came to rest inside the shape (thesis eq. (4.1), spec section 14.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from swarm_msgs_py.types import FloatArray

QUANTILE = 90.0  # spec 14.4: what is reported of the speeds of a swarm that did not settle


def settled_samples(
    positions: FloatArray, velocities: FloatArray, contour: shapely.Polygon, speed_max: float
) -> np.ndarray:
    """Return for each sample whether every robot is inside and slow, (s,) bool.

    Parameters
    ----------
    positions, velocities : (s, n, 2) array
        True states of the robots that count [m], [m/s].
    contour : shapely.Polygon
        Desired shape; `shapely.prepare` it when it is used often.
    speed_max : float
        Robots at this speed or above it move [m/s].
    """
    settled: np.ndarray = np.all(np.hypot(velocities[..., 0], velocities[..., 1]) < speed_max, axis=1)
    slow = np.flatnonzero(settled)
    settled[slow] = shapely.contains_xy(contour, positions[slow, :, 0], positions[slow, :, 1]).all(axis=1)
    return settled


@dataclass(frozen=True, slots=True)
class Settling:
    """Whether and when the swarm settled.

    Attributes
    ----------
    time : float or None
        From here on, for at least the hold time and to the end of the record, all were inside and slow [s].
    inside_fraction : float
        Share of the robots inside at the end.
    speed_p90 : float
        90th percentile of the speeds at the end [m/s].
    """

    time: float | None
    inside_fraction: float
    speed_p90: float


def settling(  # noqa: PLR0913 - two thresholds of spec 14.4 beside the record
    times: FloatArray,
    positions: FloatArray,
    velocities: FloatArray,
    contour: FloatArray,
    *,
    speed_max: float,
    hold: float,
) -> Settling:
    """Evaluate spec 14.4 on a record.

    Parameters
    ----------
    times : (s,) array
        s >= 1 [s].
    positions, velocities : (s, n, 2) array
        True states of the robots that count, n >= 1 [m], [m/s].
    contour : (k, 2) array
        Desired shape [m].
    speed_max : float
        [m/s].
    hold : float
        How long the swarm must have stayed settled [s].
    """
    polygon = shapely.Polygon(contour)
    shapely.prepare(polygon)
    unsettled = np.flatnonzero(~settled_samples(positions, velocities, polygon, speed_max))
    first = int(unsettled[-1]) + 1 if len(unsettled) else 0
    # Sample times are sums of fractions of a tick; a hold may fall short of itself by rounding.
    is_held = first < len(times) and times[-1] - times[first] >= hold - 1e-9
    inside = shapely.contains_xy(polygon, positions[-1, :, 0], positions[-1, :, 1])
    speeds = np.linalg.norm(velocities[-1], axis=1)
    return Settling(
        float(times[first]) if is_held else None, float(inside.mean()), float(np.percentile(speeds, QUANTILE))
    )
