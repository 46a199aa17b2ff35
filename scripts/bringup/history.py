"""What a run leaves to be looked at, beside the motion: radio links, paths, shape and goals over time, alerts.

Kept as changes, so that it costs little: most links, paths and goals are the same from one tick to the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bringup.engine import FormationRecord, TickRecord
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.types import FloatArray, NodeId

Pair = tuple[int, int]
NOT_REPORTED = -1
"""Mode of a robot that has told none."""


def reported_modes(record: TickRecord[Any, Any]) -> np.ndarray:
    """Return the mode that each robot has told in a tick, (n,); `NOT_REPORTED` of those that were silent."""
    modes = np.full(len(record.truth.alive), NOT_REPORTED, dtype=np.int64)
    for robot, report in record.reports.items():
        modes[robot] = report.mode
    return modes


@dataclass(slots=True)
class PointSets:
    """Sets of points that change now and then, each with the tick from which on it holds."""

    ticks: list[int] = field(default_factory=list)
    points: list[FloatArray] = field(default_factory=list)

    def put(self, tick: int, points: FloatArray) -> None:
        """Take what the set is at a tick; kept if it is another one than before."""
        if not self.points or not np.array_equal(self.points[-1], points):
            self.ticks.append(tick)
            self.points.append(np.array(points, dtype=np.float64).reshape(-1, 2))

    def arrays(self, name: str) -> Mapping[str, np.ndarray]:
        """Return ``<name>_tick``, ``<name>_sizes`` (k,) and, one set after the other, ``<name>_points`` (p, 2)."""
        return {
            f"{name}_tick": np.array(self.ticks, dtype=np.int32),
            f"{name}_sizes": np.array([len(points) for points in self.points], dtype=np.int32),
            f"{name}_points": np.concatenate([np.empty((0, 2)), *self.points]),
        }


class PairChanges:
    """Pairs that come and go, such as radio links and docks: kept as what changed."""

    def __init__(self) -> None:
        self._pairs: set[Pair] = set()
        self._changes: list[tuple[int, int, int, bool]] = []

    def put(self, tick: int, pairs: Iterable[Pair]) -> None:
        """Take in which pairs there are at a tick; the order in a pair does not matter."""
        now = {(min(pair), max(pair)) for pair in pairs}
        self._changes += [(tick, *pair, False) for pair in sorted(self._pairs - now)]
        self._changes += [(tick, *pair, True) for pair in sorted(now - self._pairs)]
        self._pairs = now

    def arrays(self, name: str) -> Mapping[str, np.ndarray]:
        """Return ``<name>_tick``, ``<name>_up`` (c,) and ``<name>_nodes`` (c, 2)."""
        changes = np.array(self._changes, dtype=np.int32).reshape(-1, 4)
        return {
            f"{name}_tick": changes[:, 0],
            f"{name}_nodes": changes[:, 1:3],
            f"{name}_up": changes[:, 3].astype(bool),
        }


class Chronicle:
    """What viewers of a run of any family want to see: who hears whom, what was on the air, what went wrong."""

    def __init__(self) -> None:
        self._links = PairChanges()
        self._alerts: list[tuple[int, str]] = []
        self._radio: list[tuple[int, int]] = []  # bytes and frames

    def take(self, record: TickRecord[Any, Any], links: Iterable[Pair]) -> None:
        """Append one tick, in which two radios are linked if either hears the other."""
        self._alerts += [(record.tick, alert) for alert in record.alerts]
        self._radio.append((record.truth.radio.bytes, record.truth.radio.frames))
        self._links.put(record.tick, links)

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return what was noted.

        Changes of links, ``link_*`` (`PairChanges`); ``alert_tick``, ``alert_text`` (a,); ``radio_bytes`` and
        ``radio_frames``, by tick (t,).
        """
        radio = np.array(self._radio, dtype=np.int64).reshape(-1, 2)
        return {
            **self._links.arrays("link"),
            "alert_tick": np.array([tick for tick, _ in self._alerts], dtype=np.int32),
            "alert_text": np.array([text for _, text in self._alerts], dtype=np.str_),
            "radio_bytes": radio[:, 0],
            "radio_frames": radio[:, 1],
        }


class History:
    """Collects, tick by tick, what viewers of a formation want to see and no metric needs."""

    def __init__(self) -> None:
        self._chronicle = Chronicle()
        self._paths: dict[NodeId, PointSets] = {}
        self._shapes, self._goals = PointSets(), PointSets()
        self._gaps: list[tuple[int, float]] = []  # overlaps, clearance

    def record(self, record: FormationRecord, course: Course) -> None:
        """Append one tick.

        Parameters
        ----------
        record : FormationRecord
        course : Course
            The plans up to this tick.
        """
        tick, truth = record.tick, record.truth
        self._chronicle.take(record, heard_pairs(record))
        self._gaps.append((len(truth.overlaps), truth.min_clearance))
        for robot, report in record.reports.items():
            self._paths.setdefault(robot, PointSets()).put(tick, report.path)
        if course.plans:
            plan = course.at(tick)
            self._shapes.put(tick, contour_at(plan, tick))
            self._goals.put(tick, goals_at(plan, tick))

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return everything recorded so far, by the names of ``trajectories.npz`` (`bringup.trajectories`)."""
        gaps = np.array(self._gaps, dtype=np.float64).reshape(-1, 2)
        paths = [
            (tick, robot, points)
            for robot, sets in sorted(self._paths.items())
            for tick, points in zip(sets.ticks, sets.points, strict=True)
        ]
        return {
            **self._chronicle.arrays(),
            "path_tick": np.array([tick for tick, _, _ in paths], dtype=np.int32),
            "path_robot": np.array([robot for _, robot, _ in paths], dtype=np.int32),
            "path_sizes": np.array([len(points) for _, _, points in paths], dtype=np.int32),
            "path_points": np.concatenate([np.empty((0, 2)), *(points for _, _, points in paths)]),
            **self._shapes.arrays("shape"),
            **self._goals.arrays("goals"),
            "overlaps": gaps[:, 0].astype(np.int64),
            "clearance": gaps[:, 1],
        }


def heard_pairs(record: FormationRecord) -> set[Pair]:
    """Return the radios of which one hears the other, as the robots tell it, each pair once."""
    return {
        (min(robot, neighbor), max(robot, neighbor))
        for robot, report in record.reports.items()
        for neighbor in report.neighbors
    }
