"""The leader's layouts: few places, linked, covering; and the lattice for many robots."""

from __future__ import annotations

import numpy as np
import pytest
from coverage_shapes import BEAM, EXPERIMENTS
from coverage_swarm import CHEAP

from swarm_agent.coverage.config import CoverageConfig
from swarm_agent.coverage.layout import plan_layout
from swarm_agent.coverage.layout_tree import rooted, with_relays
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.coverage import CoverageProbe

FOLLOWERS = {"ball": 26, "ball70": 11, "box": 8, "cross": 14}
COVERED = {"ball": 0.9995, "ball70": 0.999, "box": 0.9995, "cross": 0.9995}


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_layout_needs_few_robots_for_the_papers_shapes(name: str) -> None:
    solid, radius = EXPERIMENTS[name]
    layout = plan_layout(solid, np.zeros(3), CoverageConfig(range_m=radius))

    quality = CoverageProbe(solid, radius, seed=3, outer=1000).measure(layout.positions)
    assert len(layout.positions) - 1 <= FOLLOWERS[name]
    assert quality.covered_fraction >= COVERED[name]
    assert layout.edge_lengths.max() <= 0.95 * radius * (1.0 + 1e-9)
    assert (layout.parents[1:] < np.arange(1, len(layout.parents))).all()


def test_a_leader_that_stands_elsewhere_keeps_its_place() -> None:
    leader = np.array([-140.0, 20.0, -10.0])
    layout = plan_layout(BEAM, leader, CoverageConfig())

    assert np.array_equal(layout.positions[0], leader)
    assert CoverageProbe(BEAM, 50.0, seed=3, outer=1000).measure(layout.positions).covered_fraction >= 0.9995


def test_equal_inputs_give_equal_layouts() -> None:
    first, second = (plan_layout(BEAM, np.zeros(3), CoverageConfig(layout=CHEAP), seed=7) for _ in range(2))

    assert first.positions.tobytes() == second.positions.tobytes()


def test_many_robots_stand_on_a_lattice_of_linked_chains() -> None:
    solid = solid_from({"kind": "ball", "radius_m": 200.0})
    layout = plan_layout(solid, np.zeros(3), CoverageConfig(range_m=42.0))

    quality = CoverageProbe(solid, 42.0, seed=3, outer=1000).measure(layout.positions)
    assert quality.covered_fraction >= 0.9995
    assert layout.edge_lengths.max() <= 0.95 * 42.0 * (1.0 + 1e-9)
    assert (
        len(layout.positions) < 4.0 / 3.0 * np.pi * 200.0**3 / 42.0**3
    )  # a robot covers more than a cube of the range


def test_relays_bridge_gaps_and_nothing_else() -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [3.5, 0.0, 0.0]])

    relayed = with_relays(line, 1.0)

    assert len(relayed) == 5
    assert rooted(line, 1.0) is None
    assert rooted(relayed, 1.0) is not None


def test_a_rooted_tree_has_fewest_hops() -> None:
    places = np.concatenate([np.zeros((1, 3)), rng_for(0, "tree").random((40, 3))])
    layout = rooted(places, 0.6)

    assert layout is not None
    hops = np.zeros(41, dtype=int)
    for robot in range(1, 41):
        hops[robot] = hops[layout.parents[robot]] + 1
    distances = np.linalg.norm(layout.positions[:, None] - layout.positions, axis=2)
    linked = (distances <= 0.6) & (distances > 0.0)
    assert all(hops[robot] <= hops[linked[robot]].min() + 1 for robot in range(41))
