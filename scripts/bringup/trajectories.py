"""What ``trajectories.npz`` holds: all that is needed to look at a run again."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bringup.history import History
from bringup.layout import robot_types, sensor_carriers
from bringup.scenario import Scenario
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import Mode
from swarm_sim.metrics.trace import TraceRecorder


def trajectory_arrays(
    scenario: Scenario, recorder: TraceRecorder, plan: Plan | None, history: History
) -> Mapping[str, np.ndarray]:
    """Return what ``trajectories.npz`` holds, by name; SI units, rows in the order of robot ids.

    Motion samples: ``time`` (s,), ``position``, ``velocity`` (s, n, 2). Ticks: ``tick_time`` (t,), ``yaw``, ``alive``,
    ``mode``, ``goal``, ``positioning``, ``beacons`` (t, n), ``estimate`` (t, n, 2), ``covariance`` (t, n, 2, 2);
    ``radio_bytes``, ``radio_frames``, ``overlaps``, ``clearance`` (t,). What the values of ``mode`` mean, from 0 on:
    ``mode_names`` (m,). Robots: ``robot``, ``robot_type``, ``coverage_radius``, ``carries_sensor`` (n,).
    Final plan: ``contour`` (k, 2), ``goals`` (g, 2), ``goal_type`` (g,).
    Arena: ``period`` (), ``bounds`` (4,) as x and y of the lower left and the upper right corner,
    ``mission_position`` (2,), all corners of obstacles in ``obstacle_corners`` (c, 2), of which obstacle i has
    ``obstacle_sizes[i]``.

    Over time, as changes, each from its tick on. Shape and goals: ``shape_tick``, ``shape_sizes`` (k,) and one after
    the other the points, ``shape_points`` (p, 2); so ``goals_tick``, ``goals_sizes``, ``goals_points``. Paths as the
    robots meant to drive: ``path_tick``, ``path_robot``, ``path_sizes``, ``path_points``. Radio links that came or
    went: ``link_tick``, ``link_up`` (l,), ``link_nodes`` (l, 2), the mission computer by its address `MISSION`.
    Alerts: ``alert_tick``, ``alert_text``.
    """
    trace, types = recorder.trace(), robot_types(scenario)
    obstacles = [obstacle.polygon() for obstacle in scenario.map.obstacles]
    carriers = sensor_carriers(scenario)
    return {
        "time": trace.sample_times,
        "position": trace.positions,
        "velocity": trace.velocities,
        "tick_time": trace.tick_times,
        "yaw": trace.yaws,
        "alive": trace.alive,
        "mode": trace.modes,
        "mode_names": np.array([mode.name.lower().replace("_", " ") for mode in Mode]),
        "goal": trace.goals,
        "estimate": trace.estimates,
        "covariance": trace.covariances,
        "positioning": trace.positioning,
        "beacons": trace.beacons,
        "robot": np.array(trace.robots, dtype=np.int64),
        "robot_type": np.array([kind.type for kind in types], dtype=np.int64),
        "coverage_radius": np.array([kind.coverage_radius_m for kind in types]),
        "carries_sensor": np.array([robot in carriers for robot in trace.robots]),
        "contour": plan.contour if plan else np.empty((0, 2)),
        "goals": plan.goals if plan else np.empty((0, 2)),
        "goal_type": plan.goal_types if plan else np.empty(0, dtype=np.int64),
        "period": np.array(scenario.sim.period_s),
        "bounds": np.array(scenario.map.bounds_m, dtype=np.float64),
        "mission_position": np.array(scenario.mission.position_m, dtype=np.float64),
        "obstacle_corners": np.concatenate([np.empty((0, 2)), *obstacles]),
        "obstacle_sizes": np.array([len(obstacle) for obstacle in obstacles], dtype=np.int64),
        **history.arrays(),
    }
