"""Cost of one tick of the simulated world: physics alone, and with sensors and radio.

Prints median milliseconds per tick of 0.5 s (and the best tick, which noise of the machine touches least) for both back
ends and three swarm sizes, on rough ground with six obstacles.
Run it on an otherwise idle machine: ``python benchmarks/bench_world.py``.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.config import Backend, PhysicsConfig, SimConfig
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.simulation import Simulation
from swarm_sim.world.registry import make_world
from swarm_sim.world.world import World

SIZES = (10, 50, 100)
TICKS = 40
SPACING_M = 2.2
HELLO, PACKET = b"h" * 60, b"p" * 90


def main(sizes: Sequence[int] = SIZES, ticks: int = TICKS) -> None:
    """Measure and print the table."""
    print(
        f"{'back end':<12}{'robots':>7}{'start ms':>10}{'physics ms':>12}{'best ms':>10}"
        f"{'observe ms':>12}{'radio ms':>10}"
    )
    for backend in Backend:
        config = SimConfig(physics=PhysicsConfig(backend=backend))
        for size in sizes:
            scene = make_scene(size)
            began = time.perf_counter()
            world = make_world(config, scene, seed=1)
            start_ms = 1e3 * (time.perf_counter() - began)
            physics_ms, best_ms = measure_physics(world, size, ticks)
            world.close()
            observe_ms, radio_ms = measure_simulation(Simulation(config, scene, seed=1), ticks)
            print(
                f"{backend.value:<12}{size:>7}{start_ms:>10.1f}{physics_ms:>12.2f}{best_ms:>10.2f}{observe_ms:>12.2f}{radio_ms:>10.2f}"
            )


def make_scene(size: int) -> Scene:
    """Return robots on a square grid, all in radio range of many others, among six obstacles."""
    side = int(np.ceil(np.sqrt(size)))
    first = -SPACING_M * (side - 1) / 2.0
    robots = tuple(
        RobotSpec(
            NodeId(i), THESIS_TYPES[i % 3], (first + SPACING_M * (i % side), first + SPACING_M * (i // side)), 0.0, True
        )
        for i in range(size)
    )
    angles = np.arange(6) * np.pi / 3.0
    obstacles = tuple(block(18.0 * np.cos(a), 18.0 * np.sin(a)) for a in angles)
    return Scene(robots, obstacles, (-50.0, -50.0, 50.0, 50.0), (0.0, 25.0))


def block(x: float, y: float) -> FloatArray:
    """Return a square obstacle of 3 m."""
    return np.array([(x - 1.5, y - 1.5), (x + 1.5, y - 1.5), (x + 1.5, y + 1.5), (x - 1.5, y + 1.5)])


def measure_physics(world: World, size: int, ticks: int) -> tuple[float, float]:
    """Return the median and the least cost of one control period [ms]; every fifth tick all setpoints change."""
    rng = np.random.default_rng(0)
    setpoints, costs = np.zeros((size, 3)), []
    for tick in range(ticks):
        if tick % 5 == 0:
            setpoints[:, :2] = rng.uniform(-0.3, 0.3, (size, 2))
        costs.append(cost_of(partial(world.advance, setpoints)))
    return statistics.median(costs), min(costs)


def measure_simulation(sim: Simulation, ticks: int) -> tuple[float, float]:
    """Return the median cost of all sensors and of the radio with two frames per robot [ms]."""
    observing, sending = [], []
    command = VelocityCommand(0.1, 0.0)
    for _ in range(ticks // 2):
        observing.append(cost_of(sim.observe))
        commands = dict.fromkeys(sim.robots, command)
        outboxes = dict.fromkeys((*sim.robots, MISSION), (HELLO, PACKET))
        sending.append(cost_of(partial(sim.apply, commands, outboxes)))
        sim.advance()
    sim.close()
    return statistics.median(observing), statistics.median(sending)


def cost_of(action: Callable[[], object]) -> float:
    """Return the wall time of one call [ms]."""
    began = time.perf_counter()
    action()
    return 1e3 * (time.perf_counter() - began)


if __name__ == "__main__":
    main()
