"""The engine with real processes: same motion as without ROS, deaths are named, nothing is left over."""

from __future__ import annotations

import os
import signal
import time
from itertools import islice
from pathlib import Path

import pytest
from leftovers import SHARED_MEMORY, is_running, wait_until
from swarms import SmallSwarm

from bringup.domain_guard import DomainGuard
from bringup.inprocess import InProcessEngine
from bringup.ros_engine import RosEngine, default_agents_per_process
from swarm_agent.agent import Agent
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.messages.bodies import Task
from swarm_msgs_py.plan_goals import goals_crc
from swarm_msgs_py.ros.environment import use_loopback
from swarm_msgs_py.types import MISSION, NodeId

pytestmark = pytest.mark.usefixtures("domain_id")

NAMED_DEADLINE_S = 1.0


def engine_of(count: int, per_process: int) -> RosEngine:
    return RosEngine(SmallSwarm(count), agents_per_process=per_process, deadline_s=5.0)


def pid_of(engine: RosEngine, name: str) -> int:
    return next(child.pid for child in engine._group.children if child.name == name)


@pytest.mark.usefixtures("nothing_left")
def test_twenty_ticks_in_processes_are_the_same_as_without_ros() -> None:
    with engine_of(4, 2) as engine:
        records = list(islice(engine.ticks(), 20))
    with InProcessEngine(SmallSwarm(4)) as reference:
        expected = list(islice(reference.ticks(), 20))

    for record, wanted in zip(records, expected, strict=True):
        assert record.tick == wanted.tick
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert record.reports.keys() == wanted.reports.keys()
        assert all(record.reports[r].path.tobytes() == wanted.reports[r].path.tobytes() for r in wanted.reports)
        assert record.mission == wanted.mission
        assert (record.plan is None) == (wanted.plan is None)
        assert (record.alerts, record.lost) == (wanted.alerts, wanted.lost)
    assert engine.startup_s > 0.0


@pytest.mark.usefixtures("nothing_left")
@pytest.mark.parametrize("task", [Task.GOALS, Task.PARTITION, Task.FORCES])
def test_deaths_of_the_scenario_are_the_same_as_without_ros_whatever_the_plan_asks(task: Task) -> None:
    swarm = SmallSwarm(4, deaths=((NodeId(2), 0), (NodeId(1), 6), (MISSION, 8)), task=task)
    with RosEngine(swarm, agents_per_process=2) as engine:
        records = list(islice(engine.ticks(), 12))
    with InProcessEngine(swarm) as reference:
        expected = list(islice(reference.ticks(), 12))

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert record.truth.alive.tolist() == wanted.truth.alive.tolist()
        assert list(record.reports) == list(wanted.reports)
        assert (record.alerts, record.lost, record.mission) == (wanted.alerts, wanted.lost, wanted.mission)
        assert [its.goals_crc for its in record.reports.values()] == [its.goals_crc for its in wanted.reports.values()]
    assert records[6].alerts == ("r01 dies, as the scenario says",)
    assert records[8].alerts == ("mission computer is switched off, as the scenario says",)
    assert [record.mission is None for record in records] == [False] * 8 + [True] * 4
    assert records[11].lost == {1, 2, MISSION}
    plan = records[0].plan
    assert plan is not None
    assert plan.task is task
    held = {report.goals_crc for report in records[11].reports.values()}  # in two processes
    assert held == {goals_crc(plan.goals, plan.goal_types)}
    assert (held == {0}) == (task is Task.FORCES)


@pytest.mark.usefixtures("nothing_left")
def test_a_killed_process_is_named_and_the_others_go_on() -> None:
    with engine_of(4, 2) as engine:
        ticks = engine.ticks()
        first = list(islice(ticks, 5))
        pid = pid_of(engine, "r01, r03")
        killed_at = time.monotonic()
        os.kill(pid, signal.SIGKILL)
        named_after = next(
            time.monotonic() - killed_at for record in ticks for line in record.alerts if line.startswith("r01, r03")
        )
        later = list(islice(ticks, 12))

    assert all(record.lost == frozenset() for record in first)
    assert named_after < NAMED_DEADLINE_S
    assert later[-1].lost == {NodeId(1), NodeId(3)}
    assert later[-1].reports.keys() == {NodeId(0), NodeId(2)}
    assert later[-1].truth.alive.tolist() == [True, False, True, False]


@pytest.mark.usefixtures("nothing_left")
def test_a_dead_mission_computer_is_survived() -> None:
    with engine_of(2, 2) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 5))
        os.kill(pid_of(engine, "mission computer"), signal.SIGKILL)
        later = list(islice(ticks, 15))

    assert any("mission computer (process" in line and "SIGKILL" in line for r in later for line in r.alerts)
    assert later[-1].lost == {MISSION}
    assert later[-1].mission is None
    assert later[-1].reports.keys() == {NodeId(0), NodeId(1)}


@pytest.mark.usefixtures("nothing_left")
def test_without_the_world_the_run_ends_with_one_line() -> None:
    with engine_of(2, 2) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 3))
        os.kill(pid_of(engine, "world"), signal.SIGKILL)

        with pytest.raises(SwarmError, match=r"^world \(process \d+\) died: signal 9 \(SIGKILL\); without it"):
            list(islice(ticks, 1000))


@pytest.mark.usefixtures("nothing_left")
def test_interrupted_children_keep_running_and_end_only_with_the_engine() -> None:
    with engine_of(2, 1) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 2))
        for child in engine._group.children:
            os.kill(child.pid, signal.SIGINT)  # as Ctrl-C does to a whole foreground process group

        assert [record.alerts for record in islice(ticks, 10)] == [()] * 10


@pytest.mark.usefixtures("nothing_left")
def test_no_shared_memory_file_is_made_so_none_can_be_left_after_a_kill() -> None:
    with engine_of(2, 1) as engine:
        list(islice(engine.ticks(), 3))
        pids = [child.pid for child in engine._group.children]
        mapped = [line for pid in pids for line in Path(f"/proc/{pid}/maps").read_text().splitlines()]
        opened = [os.readlink(file) for pid in pids for file in Path(f"/proc/{pid}/fd").iterdir()]

    assert not [line for line in (*mapped, *opened) if str(SHARED_MEMORY) in line and "fast" in line]


@pytest.mark.usefixtures("nothing_left")
def test_children_die_with_a_parent_that_is_killed_and_its_domain_is_free_again() -> None:
    reading, writing = os.pipe()
    parent = os.fork()
    if parent == 0:
        try:
            with engine_of(2, 1) as engine:
                list(islice(engine.ticks(), 2))
                os.write(writing, " ".join(str(child.pid) for child in engine._group.children).encode())
                signal.pause()
        finally:
            os._exit(1)
    pids = [int(word) for word in os.read(reading, 1000).split()]
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    os.close(reading)
    os.close(writing)

    assert len(pids) == 4
    assert wait_until(lambda: not any(is_running(pid) for pid in pids))


@pytest.mark.usefixtures("nothing_left")
def test_an_actor_that_cannot_be_made_stops_the_start_with_its_reason() -> None:
    class Broken(SmallSwarm):
        def agent(self, robot: NodeId) -> Agent:
            if robot == 1:
                raise ValueError("no firmware for r01")
            return super().agent(robot)

    with pytest.raises(SwarmError, match="start: r01 cannot be made: ValueError: no firmware for r01"):
        RosEngine(Broken(2), agents_per_process=2).__enter__()


def test_a_second_swarm_in_the_same_domain_is_refused_with_the_way_out(domain_id: int) -> None:
    guard = DomainGuard(domain_id)
    guard.acquire()
    try:
        with pytest.raises(ConfigError, match=rf"domain {domain_id} is in use by the swarm of process {os.getpid()}"):
            engine_of(2, 2).__enter__()
    finally:
        guard.release()
    guard.acquire()
    guard.release()


@pytest.mark.parametrize("text", ["-1", "233", "x", "1.5"])
def test_a_domain_that_does_not_exist_is_refused(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", text)

    with pytest.raises(ConfigError, match=f"ROS_DOMAIN_ID: .* got '{text}'"):
        engine_of(2, 2).__enter__()


def test_more_processes_than_find_each_other_are_refused() -> None:
    with pytest.raises(ConfigError, match="--agents-per-process 1: 200 processes"):
        engine_of(200, 1).__enter__()


def test_the_default_fills_the_cores_and_no_more() -> None:
    cores = os.cpu_count() or 1

    assert [default_agents_per_process(n) for n in (1, cores, 10 * cores)] == [1, 1, 10]


def test_what_the_user_has_chosen_for_the_middleware_stays(tmp_path: Path) -> None:
    assert use_loopback(quiet := {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, tmp_path) is False
    assert quiet == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    assert use_loopback(own := {"FASTRTPS_DEFAULT_PROFILES_FILE": "/mine.xml"}, tmp_path) is False
    assert own == {"FASTRTPS_DEFAULT_PROFILES_FILE": "/mine.xml", "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    assert use_loopback(default := {}, tmp_path) is True
    assert "127.0.0.1" in Path(default["FASTRTPS_DEFAULT_PROFILES_FILE"]).read_text()
