"""Small valid scenes and settings of the simulated world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from swarm_msgs_py.robots import THESIS_TYPES, RobotType
from swarm_msgs_py.types import FloatArray, NodeId
from swarm_sim.config import Backend, Ground, PhysicsConfig, SimConfig, TerrainConfig
from swarm_sim.scene import RobotSpec, Scene

BOUNDS = (-10.0, -10.0, 10.0, 10.0)


def make_robot(
    number: int, position: tuple[float, float], kind: RobotType = THESIS_TYPES[0], **changes: Any
) -> RobotSpec:
    """Return a robot that looks along +x and carries a position sensor."""
    return replace(RobotSpec(NodeId(number), kind, position, 0.0, True), **changes)


def make_scene(
    robots: Sequence[RobotSpec] = (make_robot(0, (0.0, 0.0)),),
    obstacles: Sequence[FloatArray] = (),
    mission_position: tuple[float, float] = (0.0, 8.0),
) -> Scene:
    """Return a scene of 20 m x 20 m."""
    return Scene(tuple(robots), tuple(obstacles), BOUNDS, mission_position)


def make_row(count: int, spacing: float = 2.0) -> tuple[RobotSpec, ...]:
    """Return robots of all types in turn, in a row along x about the origin."""
    first = -(count - 1) * spacing / 2.0
    return tuple(make_robot(i, (first + spacing * i, 0.0), THESIS_TYPES[i % 3]) for i in range(count))


def make_config(backend: Backend = Backend.MASSDAMPER, ground: Ground = Ground.PLANE, **changes: Any) -> SimConfig:
    """Return default settings on flat ground with the given back end."""
    settings: dict[str, Any] = {
        "physics": PhysicsConfig(backend=backend),
        "terrain": TerrainConfig(ground=ground, margin_m=5.0),
    }
    return SimConfig(**(settings | changes))


def rectangle(x_min: float, y_min: float, x_max: float, y_max: float) -> FloatArray:
    """Return an axis-parallel obstacle, counter-clockwise."""
    return np.array([(x_min, y_min), (x_max, y_min), (x_max, y_max), (x_min, y_max)], dtype=np.float64)


ELL = np.array([(-4.0, -4.0), (4.0, -4.0), (4.0, -2.0), (-2.0, -2.0), (-2.0, 4.0), (-4.0, 4.0)])
"""An L: two arms of width 2 m, inner corner at (-2, -2)."""
