"""Where an agent's tick goes: time per part of `Agent.step`, 50 robots from start to formation, all in this process.

``--figure FILE`` draws the time of one whole step, timed with nothing else measured inside it, and of its parts.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from drawing import BLUE, VERMILION, panels, save

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
from swarm_msgs_py.types import FloatArray
from swarm_sim.simulation import Simulation

TICKS = 200  # from the first on: the robots do not know yet where they are, and try several hypotheses
TARGETS_MS = {0.5: 1.0, 0.99: 5.0}  # of the share of steps
PARTS: tuple[tuple[str, Any, str], ...] = (
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


def main(arguments: Sequence[str] | None = None) -> None:
    """Run twice, with and without timers inside the step; print and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figure", type=Path, metavar="FILE", help="where to draw the result, a PNG")
    parser.add_argument("--scenario", default="formation-50", help="what to run (default: %(default)s)")
    parser.add_argument("--ticks", type=int, default=TICKS, help="that are timed (default: %(default)s)")
    options = parser.parse_args(arguments)
    whole, _ = _measure(PARTS[:1], options.scenario, options.ticks)
    steps = whole[PARTS[0][0]]
    median, p99 = np.quantile(steps, (0.5, 0.99)) / 1e3
    print(f"one agent step, timed as a whole: median {median:.2f} ms, 99th percentile {p99:.2f} ms\n")
    parts, per_tick = _measure(PARTS, options.scenario, options.ticks)
    print("| part, with all timers running | calls per tick | mean [us] | median [us] | p99 [us] | share of the tick |")
    print("| --- | --- | --- | --- | --- | --- |")
    for name, micros in parts.items():
        if not len(micros):  # nobody needed it: a robot with a position sensor asks no beacons, for one
            continue
        share = micros.sum() / options.ticks / per_tick / 1e6
        median, p99 = np.quantile(micros, (0.5, 0.99))
        calls = len(micros) / options.ticks
        print(f"| {name} | {calls:.1f} | {micros.mean():.0f} | {median:.0f} | {p99:.0f} | {share:.0%} |")
    if options.figure is not None:
        _draw(steps, parts, options.figure)


def _measure(
    parts: Sequence[tuple[str, Any, str]], source: str, ticks_timed: int
) -> tuple[dict[str, FloatArray], float]:
    """Return the time of each call [us] by part, and that of a tick of everything [s]."""
    spent: dict[str, list[float]] = defaultdict(list)
    plain = [(owner, method, getattr(owner, method)) for _, owner, method in parts]
    try:
        for (name, _, _), (owner, method, function) in zip(parts, plain, strict=True):
            setattr(owner, method, _timed(function, spent[name]))
        massdamper = Override("bench_agent.py", "sim.physics.backend", "massdamper")
        scenario = resolve(*load_scenario(source, (massdamper,)))
        with InProcessEngine(ScenarioActors(scenario)) as engine:
            ticks = engine.ticks()
            began = time.perf_counter()
            for _ in range(ticks_timed):
                next(ticks)
            per_tick = (time.perf_counter() - began) / ticks_timed
    finally:
        for owner, method, function in plain:
            setattr(owner, method, function)
    return {name: np.array(seconds) * 1e6 for name, seconds in spent.items()}, per_tick


def _draw(steps: FloatArray, parts: dict[str, FloatArray], file: Path) -> None:
    """Draw how long a step takes, with the targets, and what its parts take."""
    figure, (left, right) = panels(2)
    shares = np.arange(1, len(steps) + 1) / len(steps)
    left.plot(np.sort(steps) / 1e3, 100.0 * shares, color=BLUE)
    for share, target in TARGETS_MS.items():
        left.plot(target, 100.0 * share, "v", color=VERMILION, ms=8)
        left.annotate(
            f"at most {target:g} ms", (target, 100.0 * share), (6, -12), textcoords="offset points", fontsize=8
        )
    left.set_xscale("log")
    left.set_xlabel("time of an agent step [ms]")
    left.set_title("steps that take at most so long [%]", fontsize=10)
    inner = {name.removeprefix("- "): micros for name, micros in parts.items() if name.startswith("- ")}
    right.barh(list(inner), [micros.sum() / len(steps) / 1e3 for micros in inner.values()], color=BLUE)
    right.invert_yaxis()
    right.set_xlabel("mean time per step [ms]")
    right.set_title("where it goes", fontsize=10)
    save(figure, file)


def _timed(function: Callable[..., Any], seconds: list[float]) -> Callable[..., Any]:
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        began = time.perf_counter()
        result = function(*args, **kwargs)
        seconds.append(time.perf_counter() - began)
        return result

    return wrapper


if __name__ == "__main__":
    main()
