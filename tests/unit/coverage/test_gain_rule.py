"""The gain rule: few robots from what each knows of its surroundings, linked, without a frontier left."""

from __future__ import annotations

import numpy as np
import pytest
from coverage_shapes import EXPERIMENTS

from swarm_agent.coverage import expansion, gain
from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.expansion import Layout, expand
from swarm_agent.coverage.sense_sphere import directions_of
from swarm_agent.coverage.sites import Choice, Site
from swarm_agent.coverage.store import FrontierStore
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray

FOLLOWERS = {"ball70": 14, "box": 15, "cross": 16}


def expanded(name: str, seed: int) -> tuple[Layout, CoverageConfig]:
    solid, radius = EXPERIMENTS[name]
    config = CoverageConfig(range_m=radius, rule=Rule.GAIN)
    return expand(solid, np.zeros(3), config, 100, rng_for(seed, "gain")), config


@pytest.mark.parametrize("name", FOLLOWERS)
def test_few_linked_robots_leave_no_frontier(name: str) -> None:
    layout, config = expanded(name, 0)

    store = FrontierStore(directions_of(config), config.range_m, EXPERIMENTS[name][0])
    for place in layout.positions:
        store.enable(place)
    assert not store.is_open.any()
    assert len(layout.positions) - 1 <= FOLLOWERS[name]
    assert layout.edge_lengths.max() <= config.placement * config.range_m * (1.0 + 1e-9)


def test_equal_lots_give_equal_places() -> None:
    first, second = (expanded("box", 3)[0].positions for _ in range(2))

    assert first.tobytes() == second.tobytes()


def test_places_that_are_left_out_could_not_have_won(monkeypatch: pytest.MonkeyPatch) -> None:
    bounded = expanded("ball70", 2)[0].positions
    monkeypatch.setattr(gain, "BATCH", gain.COARSE_MAX)  # the frontier of all places is told of,
    monkeypatch.setattr(gain, "FIRST", 100)  # and all samples are compared with all robots

    assert expanded("ball70", 2)[0].positions.tobytes() == bounded.tobytes()


def test_few_owners_choose_again_and_the_best_of_them_is_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds = list[list[tuple[float, FloatArray]]]()

    class WatchedStore(FrontierStore):
        def enable(self, position: FloatArray) -> int:
            rounds.append([])
            return super().enable(position)

    def choose(config: CoverageConfig, site: Site, rng: np.random.Generator) -> Choice:
        choice = gain.best_place(config, site, rng)
        rounds[-1].append((choice.score, site.position + choice.place))
        return choice

    monkeypatch.setattr(expansion, "FrontierStore", WatchedStore)
    monkeypatch.setattr(expansion, "choose", choose)
    followers = expanded("cross", 1)[0].positions[1:]

    best = [max(choices, key=lambda entry: entry[0])[1] for choices in rounds if choices]
    np.testing.assert_array_equal(followers, best)
    assert sum(map(len, rounds)) < 2 * len(followers)


def test_a_sheet_too_thin_for_points_is_covered_too() -> None:
    sheet = solid_from({"kind": "box", "size_m": [120.0, 60.0, 0.5]})
    layout = expand(sheet, np.zeros(3), CoverageConfig(rule=Rule.GAIN), 60, rng_for(0, "gain"))

    assert 2 <= len(layout.positions) <= 12
