"""Which picture of the swarm a report replays: the seam for families of runs that want one of their own.

A view is a JavaScript class in ``page/<name>_view.js`` and, here, a function that says what the view wants beside the
replay's frames. The page shows the view that `view_of` chooses.

A family that stores positions with three coordinates is shown in space. What it is to cover may be stored as edges,
``wireframe_edges`` (e, 2, 3), or as points on its surface, ``surface_points`` (k, 3); where it changes, as ``surfaces``
(s, k, 3) with ``surface_tick`` (s,), and how far it has moved since, ``surface_shift`` (t, 3); and instead of the
changes of radio links how far a radio reaches, ``link_range`` (). One whose robots are squares on a lattice stores
``cell_size`` () and ``target_cells`` (c, 2), the centers of the wanted structure, and what is docked as changes, like
radio links: ``dock_tick``, ``dock_up`` (l,) and ``dock_nodes`` (l, 2).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from reports.packing import packed
from reports.replay_data import frame_rows
from reports.run_record import RunRecord

SURFACE_POINTS_MAX = 3000
STEP_M = 0.01  # resolution of points on a surface


@dataclass(frozen=True, slots=True)
class View:
    """A way to show the swarm.

    Attributes
    ----------
    name : str
        Its script is ``page/<name>_view.js``, which registers it under this name.
    fits : callable
        Whether it can show a run.
    data : callable
        What it needs of the run beside the frames of the replay.
    """

    name: str
    fits: Callable[[RunRecord], bool]
    data: Callable[[RunRecord], Mapping[str, Any]]


def view_of(record: RunRecord) -> View:
    """Return the first view that fits a run."""
    return next(view for view in VIEWS if view.fits(record))


def _is_spatial(record: RunRecord) -> bool:
    return bool(record.arrays["position"].shape[-1] == 3)


def _space(record: RunRecord) -> Mapping[str, Any]:
    edges = record.arrays.get("wireframe_edges", np.empty((0, 2, 3)))
    data: dict[str, Any] = {"edges": edges.round(3).tolist()}
    data["surfaces"] = _surfaces(record)
    if record.has("surface_shift") and record.arrays["surface_shift"].any():
        data["shift"] = packed(record.edge_states("surface_shift")[frame_rows(record)], STEP_M)
    if "link_range" in record.arrays:
        data["reach"] = float(record.arrays["link_range"])
    return data


def _surfaces(record: RunRecord) -> list[Mapping[str, Any]]:
    """Return points on the surface of each shape, and from which frame on it is shown."""
    if record.has("surfaces"):
        found = zip(record.arrays["surface_tick"], record.arrays["surfaces"], strict=True)
    elif record.has("surface_points"):
        found = zip([0], [record.arrays["surface_points"]], strict=True)
    else:
        return []
    frames = frame_rows(record)
    return [
        {
            "frame": int(np.searchsorted(frames, tick)),
            "points": packed(points[:: math.ceil(len(points) / SURFACE_POINTS_MAX)], STEP_M),
        }
        for tick, points in found
    ]


def _plane(record: RunRecord) -> Mapping[str, Any]:
    if not record.has("cell_size"):
        return {}
    data: dict[str, Any] = {"cell": float(record.arrays["cell_size"])}
    if record.has("target_cells"):
        data["cells"] = record.arrays["target_cells"].round(3).tolist()
    return data


VIEWS = (View("space", _is_spatial, _space), View("plane", lambda _: True, _plane))
"""All views; each run is shown by the first that fits."""
