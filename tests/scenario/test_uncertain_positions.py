"""Robots whose estimates err by meters cross each other's ways and touch nobody: avoidance only uses what it senses."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest

from bringup.compose import ScenarioActors
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.scenario import Scenario, StartSpec
from bringup.scenario_file import Origin, load_scenario, parse_assignment
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

ROBOTS, TICKS = 16, 60
BIAS_M, JUMP_M, JUMP_EVERY = 1.0, 2.0, 6  # ticks
SETTINGS = ("backend=massdamper", "robots.position_sensor_share=1.0", "shape.scale=3.2")


def crowd(seed: int) -> Scenario:
    """Return sixteen robots around a square of which each must fill a part."""
    scenario = load_scenario("smoke-4", tuple(map(parse_assignment, (*SETTINGS, f"seed={seed}"))))[0]
    kinds = (replace(scenario.robots.types[0], count=ROBOTS),)
    start = StartSpec(half_side_m=3.5, gap_m=0.3)
    return resolve(replace(scenario, robots=replace(scenario.robots, types=kinds, start=start)), Origin("test"))


def blur(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    """Let every robot believe to be elsewhere: off by a constant, and by something else every few seconds."""
    rng = rng_for(seed, "blur")
    angles: defaultdict[int, float] = defaultdict(lambda: float(rng.uniform(0.0, 2.0 * np.pi)))
    jumps: defaultdict[tuple[int, int], FloatArray] = defaultdict(lambda: draw_jump(rng))
    honest = Localizer.step

    def step(localizer: Localizer, tick: int, *args: object, **settings: object) -> Estimate | None:
        estimate = honest(localizer, tick, *args, **settings)  # type: ignore[arg-type]
        if estimate is None:
            return None
        angle = angles[id(localizer)]
        off = BIAS_M * np.array([np.cos(angle), np.sin(angle)]) + jumps[id(localizer), tick // JUMP_EVERY]
        return replace(estimate, position=estimate.position + off)

    monkeypatch.setattr(Localizer, "step", step)


def draw_jump(rng: np.random.Generator) -> FloatArray:
    angle, length = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, JUMP_M)
    return length * np.array([np.cos(angle), np.sin(angle)])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nobody_is_touched_although_all_believe_to_be_meters_elsewhere(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    blur(monkeypatch, seed)
    errors, driven, gaps = [], np.zeros(ROBOTS), []
    with InProcessEngine(ScenarioActors(crowd(seed))) as engine:
        for record in engine.ticks():
            truth = record.truth.samples[-1]
            errors += [np.hypot(*(report.position - truth[robot])) for robot, report in record.reports.items()]
            driven += np.linalg.norm(np.diff(record.truth.samples, axis=0), axis=2).sum(axis=0)
            gaps.append(record.truth.min_clearance)
            assert record.truth.overlaps == (), f"tick {record.tick}"
            if record.tick == TICKS:
                break

    assert np.quantile(errors, 0.5) > 1.0  # the blur works,
    assert driven.min() > 1.5  # everybody is driven about by it,
    assert min(gaps) < 0.3  # and they do meet
