"""Where an agent's tick goes: time per part of `Agent.step`, 50 robots from start to formation, all in this process."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable
from typing import Any

import numpy as np

from bringup.compose import ScenarioActors
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario_file import Override, load_scenario
from mission_computer.mission import Mission
from swarm_agent.agent import Agent
from swarm_agent.control.avoidance import Avoidance
from swarm_agent.control.path_follower import PathFollower
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.localization import localizer
from swarm_agent.localization.localizer import Localizer
from swarm_agent.localization.walls import WallMap
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_sim.simulation import Simulation

COUNTED = 200  # ticks, from the first on: the robots do not know yet where they are, and try several hypotheses
PARTS: tuple[tuple[str, object, str], ...] = (
    ("agent: the whole step", Agent, "step"),
    ("- mesh: frames in, neighbors, routes", MeshNetwork, "receive"),
    ("- mesh: hello and packets out", MeshNetwork, "transmit"),
    ("- localization", Localizer, "step"),
    ("  - ranges joined with hellos", localizer, "observe"),
    ("  - ranges to beacons, per hypothesis", localizer, "fuse_beacons"),
    ("  - ranges to neighbors, per hypothesis", localizer, "fuse_neighbors"),
    ("  - walls, per hypothesis", WallMap, "recognize"),
    ("- decision: goal", GoalSeeking, "step"),
    ("- decision: repair of rows", Consensus, "repair"),
    ("- control: path", PathFollower, "step"),
    ("- control: avoidance", Avoidance, "step"),
    ("mission computer: the whole step", Mission, "step"),
    ("world: sensors", Simulation, "observe"),
    ("world: radio", Simulation, "apply"),
    ("world: bodies, clearance", Simulation, "advance"),
)


def main() -> None:
    """Run and print the table."""
    spent: dict[str, list[float]] = defaultdict(list)
    for name, owner, method in PARTS:
        setattr(owner, method, _timed(getattr(owner, method), spent[name]))
    massdamper = Override("bench_agent.py", "sim.physics.backend", "massdamper")
    scenario = resolve(*load_scenario("formation-50", (massdamper,)))
    with InProcessEngine(ScenarioActors(scenario)) as engine:
        ticks = engine.ticks()
        began = time.perf_counter()
        for _ in range(COUNTED):
            next(ticks)
        per_tick = (time.perf_counter() - began) / COUNTED
    print(f"one tick of everything: {per_tick * 1e3:.1f} ms ({scenario.sim.period_s / per_tick:.1f} x real time)\n")
    print("| part | calls per tick | mean [us] | median [us] | p99 [us] | share of the tick |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, seconds in spent.items():
        micros = np.array(seconds) * 1e6
        share = micros.sum() / COUNTED / per_tick / 1e6
        median, p99 = np.quantile(micros, (0.5, 0.99))
        print(
            f"| {name} | {len(micros) / COUNTED:.1f} | {micros.mean():.0f} | {median:.0f} | {p99:.0f} | {share:.0%} |"
        )


def _timed(function: Callable[..., Any], seconds: list[float]) -> Callable[..., Any]:
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        began = time.perf_counter()
        result = function(*args, **kwargs)
        seconds.append(time.perf_counter() - began)
        return result

    return wrapper


if __name__ == "__main__":
    main()
