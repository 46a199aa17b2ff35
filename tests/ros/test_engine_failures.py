"""Robots that fail, processes that stall, a world that hangs: named in one line, and the run goes on or ends."""

from __future__ import annotations

import functools
import gc
import os
import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import islice
from types import FunctionType, ModuleType
from typing import Any

import pytest
from ros_harness import harness
from std_srvs.srv import Trigger
from swarms import SmallSwarm

from bringup.compose import ScenarioActors
from bringup.inprocess import InProcessEngine
from bringup.resolution import resolve
from bringup.ros_children import run_agents
from bringup.ros_engine import RosEngine
from bringup.scenario import Scenario
from bringup.scenario_file import load_scenario
from swarm_agent.agent import Agent
from swarm_msgs_py import topics
from swarm_msgs_py.errors import SwarmError
from swarm_msgs_py.ros.environment import PROFILE_VARIABLES
from swarm_msgs_py.step_io import AgentInputs, AgentOutputs
from swarm_msgs_py.types import NodeId
from swarm_sim.scene import Scene
from swarm_sim.simulation import Simulation

pytestmark = pytest.mark.usefixtures("domain_id")

FATAL_TICK = 5
STOP_DEADLINE_S = 3.0
STALL_TICK = 12  # beyond the first ticks, which have a longer deadline


class FaultyAgent:
    """An agent that does as it should until a tick at which something else happens."""

    def __init__(self, agent: Agent, tick: int, fault: Callable[[], None]) -> None:
        self._agent, self._tick, self._fault = agent, tick, fault

    def step(self, inputs: AgentInputs) -> AgentOutputs:
        if inputs.tick == self._tick:
            self._fault()
        return self._agent.step(inputs)


@dataclass(frozen=True)
class SwarmWithFaults(SmallSwarm):
    """Some robots with the tick at which something happens to them, and what."""

    faults: Mapping[int, tuple[int, Callable[[], None]]] = field(kw_only=True)

    def agent(self, robot: NodeId) -> Any:
        agent = super().agent(robot)
        return FaultyAgent(agent, *self.faults[robot]) if robot in self.faults else agent


def fail() -> None:
    raise ZeroDivisionError("no way\nout")


def test_a_robot_whose_step_raises_is_taken_out_and_its_process_goes_on() -> None:
    faults = {3: (FATAL_TICK, fail), 0: (2 * FATAL_TICK, fail)}

    with RosEngine(SwarmWithFaults(4, faults=faults), agents_per_process=2) as engine:
        records = list(islice(engine.ticks(), 3 * FATAL_TICK))
        statuses = [child.status for child in engine._group.children]

    alerts = [(record.tick, line) for record in records for line in record.alerts]
    assert [line for _, line in alerts] == [
        "r03 failed and is taken out: ZeroDivisionError: no way out",
        "r00 failed and is taken out: ZeroDivisionError: no way out",
    ]
    assert all(abs(tick - failed) <= 1 for (tick, _), failed in zip(alerts, (5, 10), strict=True))
    assert statuses == [None] * 4
    assert NodeId(3) not in records[FATAL_TICK].reports
    assert records[-1].lost == {NodeId(0), NodeId(3)}
    assert records[-1].reports.keys() == {NodeId(1), NodeId(2)}
    assert records[-1].truth.alive.tolist() == [False, True, True, False]


def compute() -> None:
    """Keep a core busy for longer than anybody's patience, however many others want it."""
    end = time.process_time() + 3.0
    while time.process_time() < end:
        pass


def test_a_step_that_takes_long_changes_nothing_in_simulated_time() -> None:
    deaths = ((NodeId(1), STALL_TICK - 2),)  # so r03, in the same process, reports with its next step
    faults = {3: (STALL_TICK, compute)}
    with RosEngine(SwarmWithFaults(4, deaths, faults=faults), agents_per_process=2, deadline_s=1.0) as engine:
        records = list(islice(engine.ticks(), STALL_TICK + 4))
    with InProcessEngine(SmallSwarm(4, deaths)) as reference:
        expected = list(islice(reference.ticks(), STALL_TICK + 4))

    for record, wanted in zip(records, expected, strict=True):
        assert record.truth.samples.tobytes() == wanted.truth.samples.tobytes()
        assert list(record.reports) == list(wanted.reports)
        assert (record.alerts, record.lost, record.mission) == (wanted.alerts, wanted.lost, wanted.mission)
    assert records[-1].lost == {NodeId(1)}


def hang() -> None:
    """Freeze the process here, as a debugger or a machine out of memory does."""
    os.kill(os.getpid(), signal.SIGSTOP)
    signal.pause()  # other threads of the process may take the signal first


@pytest.mark.usefixtures("nothing_left")
def test_a_process_that_hangs_is_reported_and_does_not_keep_the_swarm_from_stopping() -> None:
    faults = {1: (STALL_TICK, hang), 3: (STALL_TICK, hang)}
    with RosEngine(SwarmWithFaults(4, faults=faults), agents_per_process=2, deadline_s=2.0) as engine:
        records = list(islice(engine.ticks(), STALL_TICK + 12))
        stopping = time.monotonic()

    assert time.monotonic() - stopping < STOP_DEADLINE_S
    assert [line for record in records for line in record.alerts] == [
        f"r01, r03 did not answer tick {STALL_TICK} in time; not waited for"
    ]
    assert records[-1].reports.keys() == {NodeId(0), NodeId(2)}


def test_a_process_that_stalls_between_answering_and_reporting_does_not_hold_up_the_records() -> None:
    stepped = []

    def hang_second() -> None:  # whoever of the process comes second: the first has answered and not reported
        stepped.append(None)
        if len(stepped) == 2:
            hang()

    faults = {1: (STALL_TICK, hang_second), 3: (STALL_TICK, hang_second)}
    with RosEngine(SwarmWithFaults(4, faults=faults), agents_per_process=2, deadline_s=2.0) as engine:
        records = list(islice(engine.ticks(), STALL_TICK + 12))

    owed = [line for record in records for line in record.alerts if "did not report" in line]
    assert owed in [
        [f"{name} answered tick {STALL_TICK} but did not report; recorded without"] for name in ("r01", "r03")
    ]
    assert records[-1].reports.keys() == {NodeId(0), NodeId(2)}


def test_a_world_that_hangs_ends_the_run_with_one_line() -> None:
    with RosEngine(SmallSwarm(2), agents_per_process=2, world_deadline_s=4.0) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 3))
        os.kill(next(child.pid for child in engine._group.children if child.name == "world"), signal.SIGSTOP)

        with pytest.raises(SwarmError, match=r"^world \(process \d+\) hangs: no sign of life for 4 s; without it"):
            list(islice(ticks, 1000))


def test_a_paused_world_is_not_taken_for_one_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    with RosEngine(SmallSwarm(2), agents_per_process=2, world_deadline_s=4.0) as engine:
        ticks = engine.ticks()
        list(islice(ticks, 3))
        for name in PROFILE_VARIABLES:
            monkeypatch.delenv(name)
        with harness() as ros:
            for service in (topics.PAUSE_SERVICE, topics.RESUME_SERVICE):
                client = ros.probe.create_client(Trigger, service)
                ros.wait(client.service_is_ready, service)
                reply = client.call_async(Trigger.Request())
                ros.wait(reply.done, f"a reply of {service}")
                until = time.monotonic() + 6.0
                while service == topics.PAUSE_SERVICE and time.monotonic() < until:
                    engine._listen()  # raises if the world is given up
        list(islice(ticks, 20))


def test_a_process_of_agents_is_handed_nothing_but_what_its_robots_may_know() -> None:
    actors = ScenarioActors(resolve(*load_scenario("demo")))
    engine = RosEngine(actors)
    secrets = (Scene, Scenario, ScenarioActors, Simulation, RosEngine)

    main = engine._host({NodeId(3): engine._make_agent(NodeId(3))})

    assert isinstance(main, functools.partial)
    assert main.func is run_agents
    held = reachable(main)
    assert any(isinstance(thing, Agent) for thing in held)
    assert not [type(thing).__name__ for thing in held if isinstance(thing, secrets)]
    assert any(isinstance(thing, secrets) for thing in reachable(engine))


def reachable(start: object) -> list[object]:
    """Return all objects that can be reached from one, other than through code."""
    found, waiting = {id(start): start}, [start]
    while waiting:
        for thing in gc.get_referents(waiting.pop()):
            if id(thing) not in found and not isinstance(thing, (type, ModuleType, FunctionType)):
                found[id(thing)] = thing
                waiting.append(thing)
    return list(found.values())
