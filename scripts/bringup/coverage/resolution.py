"""Checks before a coverage run starts: shapes read and tried, ranges that fit together, events that can happen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bringup.coverage.actors import make_scene, schedule_of
from bringup.coverage.scenario import CoverageScenario, SolidSpec
from bringup.coverage.solids import described
from bringup.coverage.starts import LEADER
from bringup.labels import first_few
from bringup.origin import Origin, blamed
from mission_computer.order_desk import OrderDesk
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.geometry.solids.description import inlined, solid_from
from swarm_msgs_py.geometry.solids.sampling import volume
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId, robot_name

TRIED = 20_000  # random points by which it is seen that a shape is not empty
SENSED = 2.0  # ranges within which robots must sense each other (assumption A1)


def resolve(scenario: CoverageScenario, origin: Origin) -> CoverageScenario:
    """Return the scenario with shapes and obstacles written out, after every check that needs no run.

    Raises
    ------
    ConfigError
        One line that names the file or option, the key and the remedy.
    """
    with blamed(origin, "shape"):
        scenario = replace(scenario, shape=_written_out(scenario.shape))
    with blamed(origin, "obstacles"):
        scenario = replace(scenario, obstacles=tuple(_inlined(data, n) for n, data in enumerate(scenario.obstacles)))
    events = list(scenario.events)
    for number, event in enumerate(events):
        with blamed(origin, f"events[{number}]"):
            if event.shape is not None:
                events[number] = replace(event, shape=_written_out(event.shape))
    scenario = replace(scenario, events=tuple(events))
    _check_events(scenario, origin)
    with blamed(origin, "agent"):
        _check_ranges(scenario)
    with blamed(origin, "robots"):
        _check_starts(scenario)
    with blamed(origin, "shape"):
        OrderDesk(scenario.mission, schedule_of(scenario))  # refuses what is too large for the radio
    return scenario


def _written_out(spec: SolidSpec) -> SolidSpec:
    """Return a shape with its description written out; refuse one that is empty."""
    data = described(spec)
    volume(solid_from(data), TRIED, rng_for(0, "coverage", "trial"))
    return SolidSpec(name=spec.name or "inline solid", solid=data)


def _inlined(data: dict[str, Any], number: int) -> dict[str, Any]:
    return inlined(data, Path.cwd(), f"[{number}]")


def _check_events(scenario: CoverageScenario, origin: Origin) -> None:
    count, dead, late = scenario.robots.count, set[int](), set[int]()
    for number, event in enumerate(scenario.events):
        with blamed(origin, f"events[{number}]"):
            if event.at_s >= scenario.duration_s:
                raise ConfigError(
                    f"at_s: {event.at_s:g} s is not before the time limit of {scenario.duration_s:g} s; "
                    "lower it, or raise duration_s"
                )
            for robot in (*event.kill, *event.join):
                if robot >= count:
                    raise ConfigError(f"there is no {robot_name(NodeId(robot))}; there are {count} robots")
            for robots, seen, what in ((event.kill, dead, "killed"), (event.join, late, "let in")):
                for robot in robots:
                    if robot in seen:
                        raise ConfigError(f"{robot_name(NodeId(robot))} is {what} twice; remove it once")
                    seen.add(robot)


def _check_ranges(scenario: CoverageScenario) -> None:
    agent, sim = scenario.agent, scenario.sim
    if agent.range_m > sim.radio.range_m:
        raise ConfigError(
            f"range_m ({agent.range_m:g} m) is beyond the radio, sim.radio.range_m ({sim.radio.range_m:g} m); "
            "lower the one or raise the other"
        )
    if SENSED * agent.range_m > sim.sight_m:
        raise ConfigError(
            f"range_m: robots must sense each other within {SENSED:g} times {agent.range_m:g} m, and sim.sight_m is "
            f"{sim.sight_m:g} m; lower the one or raise the other"
        )
    if agent.motion.speed_mps > sim.speed_mps:
        raise ConfigError(
            f"motion.speed_mps: {agent.motion.speed_mps:g} m/s is beyond sim.speed_mps ({sim.speed_mps:g} m/s)"
        )


def _check_starts(scenario: CoverageScenario) -> None:
    scene = make_scene(scenario)
    inside = scene.barriers.contain(scene.starts)
    if inside.any():
        names = first_few([robot_name(NodeId(int(robot))) for robot in np.flatnonzero(inside)])
        raise ConfigError(f"{names}: would start in an obstacle; move it, or start elsewhere (seed, leader_m)")
    away = float(np.linalg.norm(scene.antenna - scene.starts[LEADER]))
    if away >= scenario.sim.radio.range_m:
        raise ConfigError(
            f"the leader starts {away:.0f} m from the mission computer and would not hear it; set mission.position_m"
        )
