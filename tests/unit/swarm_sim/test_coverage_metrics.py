"""Coverage of a solid and connectivity of robots, against values known from geometry."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_msgs_py.coverage_io import CoverageMode, CoverageReport
from swarm_msgs_py.geometry.solids.description import solid_from
from swarm_msgs_py.types import NodeId
from swarm_sim.metrics.coverage import CoverageProbe, close_pairs, component_count, live_components
from swarm_sim.metrics.covering import Covering
from swarm_sim.points.simulation import PointTruth
from swarm_sim.radio.medium import RadioTraffic

BOX = solid_from({"kind": "box", "size_m": [4.0, 2.0, 2.0]})


def test_half_of_a_box_is_covered_by_a_ball_around_half_of_it() -> None:
    quality = CoverageProbe(BOX, 2.0, seed=1, inner=20_000, outer=5_000).measure(np.array([[-1.4, 0.0, 0.0]]))
    # The ball reaches the corners of every cross section up to x = -1.4 + sqrt(2), and the axis up to x = 0.6.
    assert (2.0 + 0.014) / 4.0 < quality.covered_fraction < (2.0 + 0.6) / 4.0
    assert quality.covered_error == pytest.approx(0.0035, abs=2e-4)
    assert quality.worst_gap_m == pytest.approx(np.sqrt(3.4**2 + 2.0) - 2.0, abs=0.15)
    assert 0.5 < quality.boundary_fraction < 0.7


def test_a_covered_shape_has_no_gap() -> None:
    quality = CoverageProbe(BOX, 2.5, seed=1, inner=1000, outer=1000).measure(np.zeros((1, 3)))

    assert (quality.covered_fraction, quality.boundary_fraction, quality.worst_gap_m) == (1.0, 1.0, 0.0)


def test_links_are_strictly_shorter_than_the_range() -> None:
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.9, 0.0, 0.0]])

    assert component_count(3, close_pairs(line, 1.0)) == 2
    assert component_count(3, close_pairs(line, 1.0 + 1e-9)) == 1


def test_dead_robots_are_no_pieces() -> None:
    alive = np.array([True, False, True])

    assert live_components(alive, np.empty((0, 2), dtype=np.int64)) == 2
    assert live_components(alive, np.array([[0, 2]])) == 1


def report(mode: CoverageMode, x: float, target: float, *, is_leading: bool = False) -> CoverageReport:
    return CoverageReport(
        mode=mode,
        position=np.array([x, 0.0, 0.0]),
        target=np.array([target, 0.0, 0.0]),
        hops=0,
        searches=1,
        places=2,
        is_done=mode is CoverageMode.HOLDING,
        is_leading=is_leading,
    )


def truth(tick: int, *places: float, links: tuple[tuple[int, int], ...] = ((0, 1),)) -> PointTruth:
    positions = np.array([[place, 0.0, 0.0] for place in places])
    alive = np.ones(len(places), dtype=np.bool_)
    rows = np.array(links, dtype=np.int64).reshape(-1, 2)
    return PointTruth(tick, float(tick), positions, positions, np.zeros(len(places)), alive, rows, RadioTraffic())


def test_a_run_is_followed_from_rendezvous_to_the_last_place() -> None:
    covering = Covering(2.0)
    leader = report(CoverageMode.HOLDING, 0.0, 0.0, is_leading=True)
    gathering, under_way, there = (report(mode, 3.0, 4.0) for mode in CoverageMode if mode is not CoverageMode.WAITING)

    covering.take(truth(0, 0.0, 1.0), {NodeId(0): report(CoverageMode.GATHERING, 0.0, 0.0), NodeId(1): gathering})
    covering.take(truth(1, 0.0, 1.0, links=()), {NodeId(0): leader, NodeId(1): under_way})
    covering.take(truth(2, 0.0, 3.5), {NodeId(0): leader, NodeId(1): there})

    assert covering.times_s == (2.0, 0.0, 4.0)
    assert (covering.ticks, covering.violations, covering.connected_fraction) == (3, 1, pytest.approx(2 / 3))
    assert covering.holders == [0, 1]
    assert not covering.is_over
    errors = covering.errors(5.0, np.zeros(3))
    assert errors.placement.tolist() == [0.0, 0.5]
    assert errors.localization.tolist() == [0.0, 0.5]
    assert errors.depths.tolist() == [0, 1]
