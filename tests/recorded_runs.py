"""Made-up runs with everything in them that reports and figures show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from reports.run_record import RunRecord
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import MISSION

PERIOD, SAMPLES = 0.5, 4
MODES = ("waiting", "traveling", "parked")
METRICS: Mapping[str, Any] = {
    "scenario": "made-up",
    "family": "formation",
    "method": "bubble-packing",
    "seed": 3,
    "engine": "inprocess",
    "physics": "massdamper",
    "achieved": True,
    "reason": "shape formed",
    "settling_time_s": 4.5,
    "total_displacement_m": 12.0,
    "displacement_ratio": 1.02,
    "lost_robots": 1,
    "morph_latency_s": None,
    "stage_settling_s": [1.0, None],
}


def made_run(robots: int = 6, ticks: int = 20, **more: np.ndarray) -> RunRecord:
    """Return a run in which robots drive to the right into a shape that moves along; the last one dies half way."""
    rng = rng_for(7, "made-up run")
    starts, goals = rng.uniform(-20.0, -10.0, (robots, 2)), rng.uniform(0.0, 10.0, (robots, 2))
    samples = np.linspace(0.0, 1.0, ticks * SAMPLES + 1)[:, None, None]
    position = starts + samples * (goals - starts)
    alive = np.ones((ticks, robots), dtype=bool)
    alive[ticks // 2 :, -1] = False
    position[position.shape[0] // 2 :, -1] = position[position.shape[0] // 2, -1]
    at_ticks = position[:-1:SAMPLES]
    positioning = np.zeros((ticks, robots), dtype=np.int64)
    positioning[1:3, 0], positioning[3:5, 0] = 1, 2
    shape = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    arrays = {
        "time": np.linspace(0.0, ticks * PERIOD, ticks * SAMPLES + 1),
        "position": position,
        "tick_time": np.arange(ticks) * PERIOD,
        "yaw": np.tile(np.linspace(-3.0, 3.0, robots), (ticks, 1)),
        "alive": alive,
        "mode": np.where(np.arange(ticks)[:, None] < ticks - 2, 1, 2) * np.ones(robots, dtype=np.int64),
        "mode_names": np.array(MODES),
        "goal": np.tile(np.arange(robots), (ticks, 1)),
        "positioning": positioning,
        "estimate": at_ticks + rng.normal(0.0, 0.5, at_ticks.shape),
        "covariance": np.tile(np.diag([0.4, 0.1]), (ticks, robots, 1, 1)),
        "robot": np.arange(robots),
        "robot_type": 1 + np.arange(robots) % 3,
        "coverage_radius": np.array([0.15, 0.3, 0.5])[np.arange(robots) % 3],
        "carries_sensor": np.arange(robots) == 1,
        "period": np.array(PERIOD),
        "bounds": np.array([-25.0, -25.0, 25.0, 25.0]),
        "mission_position": np.zeros(2),
        "obstacle_corners": np.array([[-8.0, -8.0], [-4.0, -8.0], [-4.0, -4.0]]),
        "obstacle_sizes": np.array([3]),
        "shape_tick": np.arange(ticks),
        "shape_sizes": np.full(ticks, len(shape)),
        "shape_points": np.concatenate([shape + np.array([0.1 * tick, 0.0]) for tick in range(ticks)]),
        "goals_tick": np.array([0]),
        "goals_sizes": np.array([robots]),
        "goals_points": goals,
        "path_tick": np.zeros(robots, dtype=np.int64),
        "path_robot": np.arange(robots),
        "path_sizes": np.full(robots, 2),
        "path_points": np.stack([0.5 * (starts + goals), goals], axis=1).reshape(-1, 2),
        "link_tick": np.array([0, 0, 0, ticks // 2]),
        "link_nodes": np.array([[0, 1], [1, 2], [2, MISSION], [0, 1]]),
        "link_up": np.array([True, True, True, False]),
        "alert_tick": np.array([ticks // 2]),
        "alert_text": np.array(["the last robot died"]),
        "radio_bytes": np.full(ticks, 1000),
        "radio_frames": np.full(ticks, 10),
        "overlaps": np.zeros(ticks, dtype=np.int64),
        "clearance": np.linspace(1.0, 0.2, ticks),
    }
    metrics = {**METRICS, "robots": robots, "ticks": ticks, "sim_time_s": ticks * PERIOD}
    return RunRecord(metrics, "name: made-up\nseed: 3\n", {**arrays, **more})


def busy_run(robots: int, ticks: int) -> RunRecord:
    """Return a run of which nothing stays the same: every link, path and goal is another one in every tick."""
    rng = rng_for(8, "busy run")
    pairs = np.array([(a, b) for a in range(robots) for b in range(a + 1, robots) if (a + b) % 5 == 0])
    present = np.tile(np.arange(ticks) % 2 == 0, (len(pairs), 1)).T
    count = robots * ticks
    return made_run(
        robots,
        ticks,
        link_tick=np.repeat(np.arange(ticks), len(pairs)),
        link_nodes=np.tile(pairs, (ticks, 1)),
        link_up=present.ravel(),
        path_tick=np.tile(np.arange(ticks), robots),
        path_robot=np.repeat(np.arange(robots), ticks),
        path_sizes=np.full(count, 3),
        path_points=rng.uniform(-25.0, 25.0, (3 * count, 2)),
        goals_tick=np.arange(ticks),
        goals_sizes=np.full(ticks, robots),
        goals_points=rng.uniform(-25.0, 25.0, (count, 2)),
    )


def run_in_space(robots: int = 12, ticks: int = 10) -> RunRecord:
    """Return a run in three dimensions, with the solid that is to be covered."""
    flat = made_run(robots, ticks)
    height = np.linspace(0.0, 5.0, robots)[None, :, None] * np.ones((len(flat.arrays["time"]), 1, 1))
    edges = np.array([[[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]], [[10.0, 0.0, 0.0], [10.0, 10.0, 6.0]]])
    kept = {name: values for name, values in flat.arrays.items() if not name.startswith(("path", "goals", "shape"))}
    position = np.concatenate([flat.arrays["position"], height], axis=-1)
    for name in ("estimate", "covariance"):
        del kept[name]
    return RunRecord(flat.metrics, flat.scenario, {**kept, "position": position, "wireframe_edges": edges})


def run_on_lattice() -> RunRecord:
    """Return a run of square boats that dock to each other beside the cells of a wanted structure."""
    return made_run(
        cell_size=np.array(1.0),
        target_cells=np.array([[0.5, 0.5], [1.5, 0.5], [1.5, 1.5]]),
        dock_tick=np.array([5, 12]),
        dock_nodes=np.array([[0, 1], [2, 3]]),
        dock_up=np.array([True, True]),
    )


def run_of_points(robots: int = 30, ticks: int = 10) -> RunRecord:
    """Return a run in space of which nothing is stored but the motion, the surface to cover and the reach of radios."""
    full, rng = run_in_space(robots, ticks), rng_for(9, "surface")
    directions = rng.normal(size=(400, 3))
    surface = 6.0 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    kept = {name: full.arrays[name] for name in ("time", "position", "tick_time", "alive", "mode")}
    return RunRecord(full.metrics, full.scenario, {**kept, "surface_points": surface, "link_range": np.array(4.0)})


def run_of_shapes(robots: int = 5, ticks: int = 12) -> RunRecord:
    """Return a run in space whose shape moves up, and becomes another one half way, far to the right."""
    full = run_of_points(robots, ticks)
    first = full.arrays["surface_points"]
    shift = np.linspace(0.0, 6.0, ticks)[:, None] * np.array([0.0, 0.0, 1.0])
    more = {
        "surfaces": np.stack([first, first + 100.0]),
        "surface_tick": np.array([0, ticks // 2]),
        "surface_shift": shift,
    }
    return RunRecord(full.metrics, full.scenario, {**full.arrays, **more})
