"""Engine that runs every actor as a ROS 2 node, in child processes, in lockstep or in real time."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

from bringup.domain_guard import DomainGuard, domain_of
from bringup.engine import Actors, AgentActor, TickRecord
from bringup.filming import FilmOrder, develop
from bringup.labels import node_list
from bringup.patience import Patience
from bringup.process_state import computing_s
from bringup.processes import Child, Main, ProcessGroup
from bringup.readiness import await_ready
from bringup.recorder import Recorder
from bringup.ros_children import DIALECTS, run_agents, run_mission, run_world
from bringup.telemetry import AgentFailed, AgentReports, Fallen, Hosts, MissionTick, RunUntil, WorldTick, reason_of
from bringup.tick_assembly import TickAssembly
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_msgs_py.ros.channels import preload
from swarm_msgs_py.ros.environment import LOCALHOST_PROCESSES_MAX, PROCESSES_MAX, use_loopback
from swarm_msgs_py.ros.spin import has_started
from swarm_msgs_py.types import MISSION, NodeId, robot_name
from swarm_sim.ros.lockstep import PaceConfig

TICKS_AHEAD = 8
"""How far the world may run ahead of the reader of the records."""

READY_DEADLINE_S = 90.0
POLL_S = 0.5
VIEWERS = 4  # processes that are left for ROS tools
LEAN_FROM = 17  # robots from which on agents go without parameter services and log topic, to start faster
REPORT_PATIENCE_S = 2.0  # without news, for reports of a tick that the world has run


def default_agents_per_process(robots: int) -> int:
    """Return how many agents to put into one process: as many processes as the machine has cores.

    With fewer, agents wait for each other while a core idles; with more, the kernel switches between them for nothing
    (measured in docs/results.md).
    """
    return math.ceil(robots / min(robots, os.cpu_count() or 1))


class RosEngine:
    """Runs one scenario over ROS; implements `bringup.engine.Engine`.

    Parameters
    ----------
    actors : Actors
    agents_per_process : int or None
        How many agent nodes share a process; None for the best known.
    real_time : bool
        Pace ticks by the wall clock and wait for nobody.
    deadline_s : float
        In lockstep, wall time after which a node that has not answered is silent [s]. Does not run while a node that
        is waited for computes.
    world_deadline_s : float
        Wall time without a sign of life from the world's process after which the run ends [s]. A paused world gives
        signs of life.
    record_to : Path or None
        Folder, not there yet, of a bag of all topics; None to record nothing.
    film : FilmOrder or None
        That what the mission computer sees is to be filmed.

    Attributes
    ----------
    startup_s : float
        Wall time from the start until the first tick could run [s].
    notes : tuple of str
        What the operator should read after the run: what came of the recording.
    """

    def __init__(  # noqa: PLR0913 - how it is to run, and what is to be kept of it
        self,
        actors: Actors,
        *,
        agents_per_process: int | None = None,
        real_time: bool = False,
        deadline_s: float = 5.0,
        world_deadline_s: float = 60.0,
        record_to: Path | None = None,
        film: FilmOrder | None = None,
    ) -> None:
        self._actors, self._film = actors, film
        self._per_process = agents_per_process or default_agents_per_process(len(actors.robots))
        self._pace = PaceConfig(real_time=real_time, deadline_s=deadline_s)
        self._group = ProcessGroup()
        self._guard: DomainGuard | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._environment: dict[str, str] | None = None
        self._assembly = TickAssembly()
        self._for_world, self._for_reports = Patience(world_deadline_s), Patience(REPORT_PATIENCE_S)
        self._recorder = Recorder(record_to) if record_to is not None else None
        self._world: Child | None = None
        self._read = -1  # last tick that the reader of the records is done with
        self.startup_s = 0.0
        self.notes: tuple[str, ...] = ()

    def __enter__(self) -> RosEngine:
        """Start all processes and return when everybody is connected.

        Raises
        ------
        ConfigError
            If the domain is taken, or the swarm would need more processes than find each other.
        SwarmError
            If a process does not become ready, or ROS was used in this process before.
        """
        began = time.monotonic()
        try:
            self._start()
        except OSError as error:  # no process, socket or file to be had
            self.__exit__(None, None, None)
            raise SwarmError(f"the swarm did not start: {error.strerror}") from error
        except BaseException:  # also an interrupt: what was started must not stay
            self.__exit__(None, None, None)
            raise
        self.startup_s = time.monotonic() - began
        return self

    def __exit__(self, *error: object) -> None:
        """Stop all processes, by force those that do not listen, and give the domain back; may be called again."""
        if self._recorder is not None:
            self._recorder.finish(self._group)
            self.notes = (self._recorder.note(),)
        self._group.stop()
        self.notes += develop(self._film)  # here, for who filmed may have died
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None
        if self._environment is not None:
            os.environ.clear()
            os.environ.update(self._environment)
            self._environment = None
        if self._guard is not None:
            self._guard.release()

    def ticks(self) -> Iterator[TickRecord[Any, Any]]:
        """Yield one record per tick.

        Raises
        ------
        SwarmError
            If the world's process dies or hangs; without it nothing can go on.
        RuntimeError
            If the engine was not entered.
        """
        if self._world is None:
            raise RuntimeError("the engine is not running; use it as a context manager")
        while True:
            for record in self._assembly.take_ready():
                if self._recorder is not None:
                    self._recorder.expect(record)
                yield record
                self._read = record.tick
                self._let_run()
            self._listen()

    def _let_run(self) -> None:
        """Tell the world how far it may run: some ticks ahead of who reads the records, and of the recorder."""
        recorded = self._recorder.lags(self._read) if self._recorder is not None else self._read
        done = self._read if self._pace.real_time else recorded  # who goes by the wall clock waits for nobody
        if self._world is not None:
            self._world.link.send(RunUntil(done + 1 + TICKS_AHEAD))

    def _listen(self) -> None:
        """Take in what the children have sent, waiting for it a short while; notice what does not come."""
        began = time.monotonic()
        events = self._group.poll(POLL_S)
        # At most the time that was asked for: if this process was suspended, nobody has been late.
        waited = min(time.monotonic() - began, POLL_S)
        for child, message in events:
            self._take(child, message)
        senders = [child for child, _ in events]
        if self._recorder is not None and self._recorder.is_stuck(
            waited, has_news=any(map(self._recorder.is_me, senders))
        ):
            self._assembly.alert("the recorder hangs; the run goes on, the recording may have holes")
            self._let_run()
        if self._for_world.is_out(waited, has_news=self._world in senders):
            raise SwarmError(self._hang())
        # The world gives signs of life also while it waits for this process to go on, so they are no news here.
        reports = (AgentReports, MissionTick, WorldTick)
        has_news = any(isinstance(message, reports) for _, message in events) or self._is_debtor_computing()
        if self._for_reports.is_out(waited, has_news=has_news):
            self._assembly.give_up()

    def _is_debtor_computing(self) -> bool:
        """Return whether somebody who owes a report is busy with the next tick; it comes after that, at the latest."""
        owing = self._assembly.owing
        debtors = [child for child in self._group.children if child.status is None and owing.intersection(child.nodes)]
        return any(computing_s(child.pid) is not None for child in debtors)

    def _hang(self) -> str:
        process = f"world (process {self._world.pid})" if self._world is not None else "world"
        limit = self._for_world.limit_s
        return f"{process} hangs: no sign of life for {limit:g} s; without it the run cannot go on"

    def _start(self) -> None:
        if has_started():
            raise SwarmError("ROS was used in this process before, so it cannot fork a swarm; start it in a fresh one")
        self._guard = DomainGuard(domain_of(os.environ))
        self._guard.acquire()
        self._environment = dict(os.environ)
        self._folder = tempfile.TemporaryDirectory(prefix="swarm-")
        has_loopback = use_loopback(os.environ, Path(self._folder.name))
        groups = self._grouped(PROCESSES_MAX if has_loopback else LOCALHOST_PROCESSES_MAX)
        # What children would each load and compute for themselves, they inherit.
        preload()
        agents = {robot: self._make_agent(robot) for robot in sorted(self._actors.robots)}
        actors, pace, film, is_recorded = self._actors, self._pace, self._film, self._recorder is not None
        if self._recorder is not None:
            self._recorder.start(self._group, actors, DIALECTS[actors.family])
        self._world = self._group.start(
            "world", (), lambda link: run_world(link, actors, pace, is_recorded=is_recorded)
        )
        self._group.start(
            "mission computer", (MISSION,), lambda link: run_mission(link, actors, film, is_recorded=is_recorded)
        )
        for robots in groups:
            self._group.start(node_list(robots), robots, self._host({robot: agents[robot] for robot in robots}))
        await_ready(self._group, READY_DEADLINE_S)
        self._folder.cleanup()  # all have read the profile; so none is left after a kill
        self._world.link.send(Hosts({node: child.pid for child in self._group.children for node in child.nodes}))
        self._let_run()

    def _take(self, child: Child, message: object) -> None:
        """Sort what a child has sent; None means that it has died."""
        if self._recorder is not None and self._recorder.is_me(child):
            self._take_from_recorder(self._recorder, child, message)
        elif isinstance(message, AgentReports):
            self._assembly.put_agents(message)
        elif isinstance(message, WorldTick):
            self._assembly.put_world(message)
        elif isinstance(message, MissionTick):
            self._assembly.put_mission(message)
        elif isinstance(message, AgentFailed):
            self._take_out((message.robot,), f"{robot_name(message.robot)} failed and is taken out: {message.reason}")
        elif message is None:
            self._mourn(child)

    def _take_from_recorder(self, recorder: Recorder, child: Child, message: object) -> None:
        if message is None:
            self._assembly.alert(recorder.bury(child))
        else:
            recorder.take(message)
        self._let_run()

    def _mourn(self, child: Child) -> None:
        """Let the run go on without a child that has died."""
        if self._world is None or child is self._world:
            raise SwarmError(f"{child.epitaph()}; without it the run cannot go on")
        self._take_out(child.nodes, child.epitaph())

    def _take_out(self, nodes: tuple[NodeId, ...], alert: str) -> None:
        """Let the world bury some nodes, and tell the operator why."""
        self._assembly.bury(nodes)
        self._assembly.alert(alert)
        if self._world is not None:
            self._world.link.send(Fallen(nodes))

    def _make_agent(self, robot: NodeId) -> AgentActor:
        """Make one robot's agent here, so that its process need not know what agents are made from."""
        try:
            return self._actors.agent(robot)
        except Exception as error:
            name = robot_name(robot)
            raise SwarmError(f"the swarm did not start: {name} cannot be made: {reason_of(error)}") from error

    def _host(self, agents: dict[NodeId, AgentActor]) -> Main:
        """Return what the process of some agents runs; it holds nothing that those robots may not know."""
        actors, is_lean = self._actors, len(self._actors.robots) >= LEAN_FROM
        configs = {robot: actors.agent_config(robot) for robot in agents}
        return partial(
            run_agents,
            agents=agents,
            period_s=actors.period_s,
            configs=configs,
            is_lean=is_lean,
            is_recorded=self._recorder is not None,
            family=actors.family,
        )

    def _grouped(self, processes_max: int) -> list[tuple[NodeId, ...]]:
        """Return the robots of each process.

        Raises
        ------
        ConfigError
            If there would be too many processes.
        """
        robots, size = tuple(sorted(self._actors.robots)), self._per_process
        # Dealt out like cards: the world publishes in order of robot, so all processes have work from the start.
        count = math.ceil(len(robots) / size)
        groups = [robots[first::count] for first in range(count)]
        own = 2 + (self._recorder is not None)  # world and mission computer
        room = processes_max - own - VIEWERS
        if len(groups) > room:
            raise ConfigError(
                f"--agents-per-process {size}: {len(groups)} processes of agents are more than the {room} that find "
                f"each other; use {math.ceil(len(robots) / room)} or more"
            )
        return groups
