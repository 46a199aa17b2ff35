from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from arena import make_config, make_robot, make_row, make_scene, rectangle
from numpy.testing import assert_allclose, assert_array_equal

from swarm_msgs_py.errors import ConfigError, PhysicsError
from swarm_msgs_py.messages.control import STOP, VelocityCommand
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.config import Backend, FixConfig, RadioConfig, RangingConfig, ServoConfig, SimConfig
from swarm_sim.simulation import Scene, Simulation, TickTruth

FORWARD = VelocityCommand(0.4, 0.0)


def make_simulation(scene: Scene | None = None, seed: int = 1, **changes: Any) -> Simulation:
    return Simulation(make_config(**changes), scene or make_scene(make_row(3)), seed)


def run(sim: Simulation, ticks: int, command: VelocityCommand = FORWARD) -> list[TickTruth]:
    truths = []
    for _ in range(ticks):
        sim.apply(dict.fromkeys(sim.observe().agents, command), {})
        truths.append(sim.advance())
    return truths


def flat(value: Any) -> Any:
    """Return nested records as comparable plain data."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if dataclasses.is_dataclass(value):
        return {f.name: flat(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {key: flat(item) for key, item in value.items()}
    return value


def test_observing_twice_gives_the_same_and_changes_nothing() -> None:
    watched, alone = make_simulation(), make_simulation()
    for _ in range(3):
        assert flat(watched.observe()) == flat(watched.observe())
        for sim in (watched, alone):
            sim.apply(dict.fromkeys(sim.robots, FORWARD), {})
            sim.advance()

    assert flat(watched.observe()) == flat(alone.observe())


def test_ticks_and_time_count_up() -> None:
    sim = make_simulation(period_s=0.25)
    truths = run(sim, 3)

    observation = sim.observe()

    assert [truth.tick for truth in truths] == [0, 1, 2]
    assert (sim.tick, observation.tick, observation.time) == (3, 3, 0.75)
    assert all(inputs.time == 0.75 and inputs.tick == 3 for inputs in observation.agents.values())


def test_truth_describes_the_tick_that_ran() -> None:
    sim = make_simulation()
    first, second = run(sim, 2)

    assert_array_equal(second.positions, first.samples[-1])
    assert_array_equal(second.velocities, first.sample_velocities[-1])
    assert len(first.samples) >= 10
    assert_allclose(first.min_clearance, 2.0 - 0.30 - 0.50, atol=0.01)  # all drive alike: the gaps stay
    assert first.overlaps == ()


def test_frames_of_one_tick_are_heard_in_the_next() -> None:
    sim = make_simulation()
    sim.apply({}, {NodeId(0): (b"zero",), MISSION: (b"mission",)})
    truth = sim.advance()
    observation = sim.observe()

    assert observation.agents[NodeId(0)].inbox == (b"mission",)
    assert observation.agents[NodeId(1)].inbox == (b"zero", b"mission")
    assert observation.mission.inbox == (b"zero",)
    assert (truth.radio.frames, truth.radio.bytes) == (2, 11)


def test_the_operators_shape_reaches_the_mission_computer_in_that_tick_only() -> None:
    sim = make_simulation()
    shape = rectangle(0.0, 0.0, 1.0, 1.0)

    assert sim.observe(shape).mission.shape is shape
    assert sim.observe().mission.shape is None


def test_ranges_follow_the_radio_links() -> None:
    wall = rectangle(-1.2, -1.0, -0.8, 1.0)
    sim = make_simulation(make_scene(make_row(3), [wall]), ranging=RangingConfig(sigma_m=0.0))

    agents = sim.observe().agents

    assert agents[NodeId(0)].ranges.neighbors.tolist() == []
    assert agents[NodeId(1)].ranges.neighbors.tolist() == [2]
    assert_allclose(agents[NodeId(1)].ranges.ranges, [2.0])


def test_the_imu_reports_the_velocity_gained_in_the_last_tick() -> None:
    sim = make_simulation()
    truth = run(sim, 1)[0]

    sample = sim.observe().agents[NodeId(0)].imu

    assert_allclose(sample.acceleration_body, truth.sample_velocities[-1, 0] / 0.5, atol=0.05)
    assert sample.acceleration_body[0] > 0.7


def test_only_robots_with_a_position_sensor_get_a_fix() -> None:
    robots = (make_robot(0, (0.0, 0.0)), make_robot(1, (3.0, 0.0), has_position_sensor=False))
    agents = make_simulation(make_scene(robots), fix=FixConfig(sigma_m=0.0)).observe().agents

    assert agents[NodeId(0)].fix is not None
    assert_array_equal(agents[NodeId(0)].fix.position, [0.0, 0.0])
    assert agents[NodeId(1)].fix is None


def test_a_dead_robot_neither_hears_nor_speaks_nor_moves_but_its_body_stays() -> None:
    sim = make_simulation(make_scene(make_row(3, spacing=1.5)))
    run(sim, 3)
    sim.kill(NodeId(1))
    boxes = {robot: (b"%d" % robot,) for robot in sim.robots}
    sim.apply(dict.fromkeys(sim.robots, FORWARD), boxes)
    truth = sim.advance()
    after = run(sim, 3, STOP)[-1]
    observation = sim.observe()

    assert list(observation.agents) == [0, 2]
    assert truth.alive.tolist() == [True, False, True]
    assert truth.radio.frames == 2
    assert truth.sample_velocities[-1, 1, 0] < 0.05 < truth.sample_velocities[-1, 0, 0]
    gap_to_body = np.hypot(*(after.samples[-1, 1] - after.samples[-1, 2])) - THESIS_TYPES[1].coverage_radius_m
    seen = np.hypot(*observation.agents[NodeId(2)].proximity.T)
    assert np.abs(seen - gap_to_body).min() < 0.05


def test_a_robot_that_dies_does_not_finish_its_transmission() -> None:
    sim = make_simulation(radio=RadioConfig(budget_bps=1600.0))  # 100 bytes per tick
    sim.apply({}, {robot: (b"%d" % robot * 150,) for robot in sim.robots})
    sim.advance()
    sim.kill(NodeId(1))
    radio = sim.advance().radio  # also without answers, transmissions go on

    assert (radio.frames, radio.bytes, radio.dropped) == (2, 100, 1)
    assert sim.observe().mission.inbox == (b"0" * 150, b"2" * 150)


def test_death_within_a_tick_takes_effect_at_once() -> None:
    sim = make_simulation()
    sim.observe()
    sim.kill(NodeId(0))
    sim.kill(NodeId(0))  # dead is dead

    assert list(sim.observe().agents) == [1, 2]
    assert sim.observe().agents[NodeId(1)].ranges.neighbors.size  # others still range to each other


def test_a_death_does_not_change_the_noise_of_the_living() -> None:
    whole, bereft = make_simulation(), make_simulation()
    bereft.kill(NodeId(0))

    assert flat(whole.observe().agents[NodeId(2)].imu) == flat(bereft.observe().agents[NodeId(2)].imu)
    assert flat(whole.observe().agents[NodeId(2)].fix) == flat(bereft.observe().agents[NodeId(2)].fix)


def test_the_mission_computer_may_die_too() -> None:
    sim = make_simulation()
    sim.kill(MISSION)
    sim.apply({}, {NodeId(0): (b"zero",), MISSION: (b"mission",)})
    sim.advance()

    assert sim.observe().mission.inbox == ()
    assert sim.observe().agents[NodeId(1)].inbox == (b"zero",)


def test_a_silent_robot_holds_its_command_for_a_while_and_then_stops() -> None:
    sim = make_simulation(servo=ServoConfig(command_hold_s=1.0))
    run(sim, 3)

    speeds = []
    for answered in (False, False, False, False):
        if answered:
            sim.apply({NodeId(1): FORWARD}, {})
        else:
            sim.apply({NodeId(robot): FORWARD for robot in (0, 2)}, {})
        speeds.append(sim.advance().sample_velocities[-1, :, 0])

    assert_allclose(np.array(speeds)[:, 0], 0.4, rtol=0.03)
    assert_allclose(np.array(speeds)[:2, 1], 0.4, rtol=0.03)  # two ticks of 0.5 s
    assert_allclose(np.array(speeds)[3:, 1], 0.0, atol=0.02)


def test_answering_twice_in_a_tick_is_an_error() -> None:
    sim = make_simulation()
    sim.apply({}, {})

    with pytest.raises(RuntimeError, match="tick 0"):
        sim.apply({}, {})


def test_a_stranger_s_frames_are_an_error() -> None:
    with pytest.raises(KeyError):
        make_simulation().apply({}, {NodeId(77): (b"hello",)})


def test_overlaps_are_reported_by_id_where_nothing_stops_the_bodies() -> None:
    robots = (make_robot(3, (0.0, 0.0)), make_robot(8, (1.0, 0.0), yaw=np.pi))
    sim = make_simulation(make_scene(robots, [rectangle(-2.0, -6.0, 2.0, -1.0)]))
    truths = run(sim, 3)
    down = run(sim, 5, VelocityCommand(0.0, -0.5))

    assert (3, 8) in truths[-1].overlaps + truths[-2].overlaps
    assert min(truth.min_clearance for truth in truths) < 0.0
    assert any((3, -1) in truth.overlaps for truth in down)


def test_a_bad_scene_is_refused_before_anything_starts() -> None:
    with pytest.raises(ConfigError, match="overlap"):
        make_simulation(make_scene([make_robot(0, (0.0, 0.0)), make_robot(1, (0.1, 0.0))]))


def test_a_closed_simulation_does_not_run() -> None:
    sim = make_simulation()
    sim.close()
    sim.close()
    sim.apply({}, {})

    with pytest.raises(PhysicsError):
        sim.advance()


def test_a_missing_engine_is_named_with_the_way_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "swarm_sim.world.pybullet_world", None)

    with pytest.raises(PhysicsError, match="massdamper"):
        make_simulation(**{"backend": Backend.BULLET})


@pytest.mark.parametrize("backend", Backend, ids=lambda backend: backend.value)
def test_equal_runs_are_equal_byte_for_byte_with_loss_and_delay(backend: Backend) -> None:
    if backend is Backend.BULLET:
        pytest.importorskip("pybullet")
    config: SimConfig = make_config(backend, radio=RadioConfig(loss=0.2, delay_ticks_max=2))
    scene = make_scene([make_robot(i, (1.2 * i - 2.0, 0.0), THESIS_TYPES[i % 3]) for i in range(4)])
    first, second = (Simulation(config, scene, seed=4) for _ in range(2))
    for tick in range(6):
        states = []
        for sim in (first, second):
            agents = sim.observe().agents
            boxes = {robot: (b"%d-%d" % (robot, tick),) * 3 for robot in agents}
            sim.apply({robot: VelocityCommand(0.2, 0.1 * robot, 0.3) for robot in agents}, boxes)
            states.append((flat(agents), flat(sim.advance())))
        assert states[0] == states[1]
    first.close()
    second.close()


def test_who_is_to_die_at_a_tick_learns_nothing_from_that_tick_on() -> None:
    sim = Simulation(make_config(), make_scene(make_row(3)), 1, {NodeId(0): 0, NodeId(2): 2})

    present = []
    for _ in range(4):
        present.append(tuple(sim.observe().agents))
        run(sim, 1)

    assert present == [(1, 2), (1, 2), (1,), (1,)]


def test_deaths_of_the_scenario_are_told_once() -> None:
    sim = Simulation(make_config(), make_scene(make_row(3)), 1, {NodeId(2): 1, NodeId(0): 1})
    before = sim.take_died()
    run(sim, 1)

    assert (before, sim.take_died(), sim.take_died()) == ((), (0, 2), ())


def test_a_death_of_the_scenario_is_like_one_by_the_operator() -> None:
    planned = Simulation(make_config(), make_scene(make_row(3)), 1, {NodeId(1): 3})
    killed = make_simulation()
    run(planned, 3)
    run(killed, 3)
    killed.kill(NodeId(1))

    assert [flat(truth) for truth in run(planned, 3)] == [flat(truth) for truth in run(killed, 3)]


def test_a_mission_computer_that_dies_neither_hears_nor_is_heard() -> None:
    sim = Simulation(make_config(), make_scene(make_row(2)), 1, {MISSION: 2})
    heard: list[tuple[bool, int]] = []
    for _ in range(5):
        seen = sim.observe()
        heard.append((b"order" in seen.agents[NodeId(0)].inbox, len(seen.mission.inbox)))
        sim.apply({}, {MISSION: (b"order",), NodeId(0): (b"report",)})
        truth = sim.advance()

    assert heard == [(False, 0), (True, 1), (True, 0), (False, 0), (False, 0)]  # what was in the air still comes
    assert sim.take_died() == (MISSION,)
    assert truth.alive.all()
