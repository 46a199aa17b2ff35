"""Engine that runs every actor as a ROS 2 node, in child processes, in lockstep or in real time."""

from __future__ import annotations

import math
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

from bringup.domain_guard import DomainGuard, domain_of
from bringup.engine import Actors, TickRecord
from bringup.processes import Child, ProcessGroup
from bringup.readiness import await_ready
from bringup.ros_children import run_agents, run_mission, run_world
from bringup.telemetry import AgentReports, Fallen, MissionTick, RunUntil, WorldTick
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
NAMED_MAX = 12  # robots that a process is named after


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
        In lockstep, wall time after which a node that has not answered is silent [s].

    Attributes
    ----------
    startup_s : float
        Wall time from the start until the first tick could run [s].
    """

    def __init__(
        self,
        actors: Actors,
        *,
        agents_per_process: int | None = None,
        real_time: bool = False,
        deadline_s: float = 5.0,
    ) -> None:
        self._actors = actors
        self._per_process = agents_per_process or default_agents_per_process(len(actors.robots))
        self._pace = PaceConfig(real_time=real_time, deadline_s=deadline_s)
        self._group = ProcessGroup()
        self._guard: DomainGuard | None = None
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._environment: dict[str, str] | None = None
        self._assembly = TickAssembly()
        self._world: Child | None = None
        self.startup_s = 0.0

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
        except BaseException:  # also an interrupt: what was started must not stay
            self.__exit__(None, None, None)
            raise
        self.startup_s = time.monotonic() - began
        return self

    def __exit__(self, *error: object) -> None:
        """Stop all processes, by force those that do not listen, and give the domain back; may be called again."""
        self._group.stop()
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None
        if self._environment is not None:
            os.environ.clear()
            os.environ.update(self._environment)
            self._environment = None
        if self._guard is not None:
            self._guard.release()

    def ticks(self) -> Iterator[TickRecord]:
        """Yield one record per tick.

        Raises
        ------
        SwarmError
            If the world's process dies; without it nothing can go on.
        RuntimeError
            If the engine was not entered.
        """
        if self._world is None:
            raise RuntimeError("the engine is not running; use it as a context manager")
        while True:
            for record in self._assembly.take_ready():
                yield record
                self._world.link.send(RunUntil(record.tick + 1 + TICKS_AHEAD))
            for child, message in self._group.poll(POLL_S):
                self._take(child, message)

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
        self._actors.agent(min(self._actors.robots))
        actors, pace, is_lean = self._actors, self._pace, len(self._actors.robots) >= LEAN_FROM
        self._world = self._group.start("world", (), lambda link: run_world(link, actors, pace))
        self._group.start("mission computer", (MISSION,), lambda link: run_mission(link, actors))
        for robots in groups:
            self._start_agents(robots, is_lean)
        await_ready(self._group, READY_DEADLINE_S)
        self._folder.cleanup()  # all have read the profile; so none is left after a kill
        self._world.link.send(RunUntil(TICKS_AHEAD))

    def _take(self, child: Child, message: object) -> None:
        """Sort what a child has sent; None means that it has died."""
        if isinstance(message, AgentReports):
            self._assembly.put_agents(message)
        elif isinstance(message, WorldTick):
            self._assembly.put_world(message)
        elif isinstance(message, MissionTick):
            self._assembly.put_mission(message)
        elif message is None:
            self._mourn(child)

    def _mourn(self, child: Child) -> None:
        """Let the run go on without a child that has died."""
        if self._world is None or child is self._world:
            raise SwarmError(f"{child.epitaph()}; without it the run cannot go on")
        self._assembly.bury(child.nodes)
        self._assembly.alert(child.epitaph())
        self._world.link.send(Fallen(child.nodes))

    def _start_agents(self, robots: tuple[NodeId, ...], is_lean: bool) -> None:
        actors = self._actors
        name = ", ".join(robot_name(robot) for robot in robots[:NAMED_MAX])
        if len(robots) > NAMED_MAX:
            name += f" and {len(robots) - NAMED_MAX} more"
        self._group.start(name, robots, lambda link: run_agents(link, actors, robots, is_lean=is_lean))

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
        room = processes_max - 2 - VIEWERS  # world and mission computer
        if len(groups) > room:
            raise ConfigError(
                f"--agents-per-process {size}: {len(groups)} processes of agents are more than the {room} that find "
                f"each other; use {math.ceil(len(robots) / room)} or more"
            )
        return groups
