"""A covering swarm runs over ROS as it runs in one process, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from bringup.coverage.actors import CoverageActors
from bringup.coverage.resolution import resolve
from bringup.coverage.scenario import CoverageScenario
from bringup.engine import Engine, TickRecord
from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine
from bringup.scenario_file import load_any, parse_assignment
from swarm_msgs_py.coverage_io import CoverageMode, CoverageReport
from swarm_msgs_py.ros.cdr import stamp
from swarm_msgs_py.ros.convert import (
    decode_neighbors,
    decode_place,
    decode_velocity,
    encode_neighbors,
    encode_place,
    encode_velocity,
)
from swarm_msgs_py.types import NodeId
from swarm_sim.points.simulation import PointTruth

TICKS = 100
SETTINGS = ("rule=random", "expansion=parallel", "robots.count=12", "robots.start_edge_m=40.0", "sample_count=100")
EVENTS = "events=[{at_s: 80.0, kill: [11]}, {at_s: 30.0, join: [10]}]"
Record = TickRecord[PointTruth, CoverageReport]


def scenario() -> CoverageScenario:
    overrides = tuple(parse_assignment(text, CoverageScenario) for text in (*SETTINGS, EVENTS))
    loaded, origin = load_any("coverage-box", overrides)
    assert isinstance(loaded, CoverageScenario)
    return resolve(loaded, origin)


def first_ticks(engine: Engine) -> list[Record]:
    def counted() -> Iterator[Record]:
        for record in engine.ticks():
            yield record
            if record.tick == TICKS:
                return

    with engine:
        return list(counted())


@pytest.fixture(scope="module")
def runs() -> tuple[list[Record], list[Record]]:
    actors = CoverageActors(scenario())
    return first_ticks(InProcessEngine(actors)), first_ticks(RosEngine(actors))


def test_the_same_seed_gives_the_same_positions_in_both_engines(runs: tuple[list[Record], list[Record]]) -> None:
    alone, over_ros = runs

    assert len(alone) == len(over_ros) == TICKS + 1
    for here, there in zip(alone, over_ros, strict=True):
        assert here.truth.positions.tobytes() == there.truth.positions.tobytes()
        assert here.truth.alive.tolist() == there.truth.alive.tolist()
        assert here.truth.radio == there.truth.radio


def test_robots_do_the_same_and_take_places(runs: tuple[list[Record], list[Record]]) -> None:
    alone, over_ros = runs

    for here, there in zip(alone, over_ros, strict=True):
        assert {r: report.mode for r, report in here.reports.items()} == {
            r: report.mode for r, report in there.reports.items()
        }
    holding = [r for r, report in over_ros[-1].reports.items() if report.mode is CoverageMode.HOLDING]
    assert len(holding) >= 4


def test_a_robot_that_comes_later_answers_from_then_on_and_a_dead_one_no_more(
    runs: tuple[list[Record], list[Record]],
) -> None:
    _, over_ros = runs
    answered = {record.tick: set(record.reports) for record in over_ros}

    assert NodeId(10) not in answered[29]
    assert NodeId(10) in answered[30]
    assert NodeId(11) in answered[79]
    assert NodeId(11) not in answered[80]


def test_numbers_survive_the_messages_bit_for_bit() -> None:
    ids, offsets = np.array([3, 7]), np.array([[0.1, -2.0 / 3.0, 1e-9], [50.0, 0.0, -0.3]])
    tick, (read_ids, read_offsets) = decode_neighbors(encode_neighbors(9, ids, offsets))

    assert (tick, read_ids.tolist(), read_offsets.tobytes()) == (9, [3, 7], offsets.tobytes())
    assert decode_place(encode_place(stamp(9.0), offsets[0]))[1].tobytes() == offsets[0].tobytes()
    assert (
        decode_velocity(encode_velocity(stamp(9.0), "r03/base_link", offsets[1]))[1].tobytes() == offsets[1].tobytes()
    )
