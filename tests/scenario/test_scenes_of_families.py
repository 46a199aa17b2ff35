"""What onlookers see of each family, tick by tick, agrees with what is true."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from bringup.engine import TickRecord
from bringup.families import BEHAVIORS
from bringup.inprocess import InProcessEngine
from bringup.kinds import KINDS
from bringup.scenario_file import load_any, parse_assignment
from bringup.scene import GONE, RESTING, Scene, Scenes

TICKS_MAX = 400


def watched(name: str, *settings: str) -> Iterator[tuple[TickRecord, Scene, Scenes]]:
    """Yield each tick of a run with its scene, until the verdict."""
    family = load_any(name)[0].family
    overrides = tuple(parse_assignment(text, KINDS[family].scenario) for text in settings)
    scenario, origin = load_any(name, overrides)
    behavior = BEHAVIORS[family]
    scenario = behavior.resolve(scenario, origin)
    scenes, account = behavior.scenes(scenario), behavior.account(scenario)
    with InProcessEngine(behavior.actors(scenario)) as engine:
        for record, _ in zip(engine.ticks(), range(TICKS_MAX), strict=False):
            yield record, scenes.take(record), scenes
            if account.take(record) is not None:
                return
    pytest.fail("no verdict")


def check(record: TickRecord, scene: Scene, scenes: Scenes) -> None:
    """Assert what holds for the scenes of every family."""
    truth = record.truth
    assert np.array_equal(scene.positions, truth.positions)
    assert [view.robot for view in scene.robots] == list(range(len(truth.alive)))
    assert len(scenes.radii) == len(scene.robots)
    for view, is_alive in zip(scene.robots, truth.alive, strict=True):
        assert len(view.facts) == len(scenes.columns)
        assert (view.state == "off") == (not is_alive)
    for outline in (*scene.outlines, *scenes.walls, scene.places):
        assert outline.shape[1] == scene.positions.shape[1]
    assert all(0 <= end < len(scene.robots) for pair in scene.links for end in pair)


def test_a_covering_swarm_ends_with_robots_at_their_places() -> None:
    last = None
    for record, scene, scenes in watched("coverage-ball70", "robots.count=16", "events=[{at_s: 60.0, kill: [15]}]"):
        check(record, scene, scenes)
        last = scene
    assert last is not None
    holding = [view for view in last.robots if view.color == RESTING]
    assert holding
    assert all(view.facts[scenes.columns.index("to place [m]")] < 10.0 for view in holding)
    assert last.robots[15].color == GONE
    assert last.positions.shape == (16, 3)


def test_docked_boats_are_linked_and_at_their_places() -> None:
    scenes = last = None
    for record, scene, shown in watched("assembly-square"):
        check(record, scene, shown)
        scenes, last = shown, scene
    assert scenes is not None
    assert last is not None
    docked = {row for row, view in enumerate(last.robots) if view.facts[scenes.columns.index("docks")]}
    assert {end for pair in last.links for end in pair} == docked
    gaps = np.linalg.norm(last.positions[sorted(docked)][:, None] - last.places, axis=2).min(axis=1)
    assert gaps.max() < scenes.radii[0]
