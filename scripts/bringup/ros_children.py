"""What the child processes of a ROS run do: the world, the mission computer, and groups of agents."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from bringup.engine import Actors, AgentActor, AgentAnswer
from bringup.family import Family
from bringup.filming import FilmOrder, filming
from bringup.link import Link
from bringup.process_state import computing_s
from bringup.telemetry import (
    AgentFailed,
    AgentReports,
    Alive,
    Fallen,
    Hosts,
    MissionTick,
    Ready,
    RunUntil,
    Stop,
    WorldTick,
    reason_of,
)
from mission_computer.ros.mission_node import NAME as MISSION_NAME
from mission_computer.ros.mission_node import MissionNode
from recording.ros.recorder_node import NAME as RECORDER_NAME
from swarm_agent.ros.agent_node import NAME as AGENT_NAME
from swarm_agent.ros.agent_node import AgentNode
from swarm_msgs_py import topics
from swarm_msgs_py.config import Config
from swarm_msgs_py.plan_goals import forget_goals
from swarm_msgs_py.ros.assembly_dialect import ASSEMBLY
from swarm_msgs_py.ros.coverage_dialect import COVERAGE
from swarm_msgs_py.ros.dialect import Dialect
from swarm_msgs_py.ros.formation_dialect import FORMATION
from swarm_msgs_py.ros.log_bridge import bridge_logging
from swarm_msgs_py.ros.parameters import declare_config
from swarm_msgs_py.ros.spin import LEAN, is_matched, spin_for, spin_until, started
from swarm_msgs_py.step_io import MissionOutputs
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.ros.lockstep import Lockstep, PaceConfig, TickResult
from swarm_sim.ros.world_node import NAME as WORLD_NAME
from swarm_sim.ros.world_node import WorldNode

MATCH_INTERVAL_S = 0.02
CREDIT_WAIT_S = 0.05
ALIVE_INTERVAL_S = 1.0
OWN = frozenset({WORLD_NAME, MISSION_NAME, AGENT_NAME, RECORDER_NAME})
"""Names of the nodes whose ears count when a process waits for its partners; somebody may look on, too."""
LOG_LEVEL = logging.WARNING  # the operator reads the alerts; what goes well is not worth a line from fifty nodes
"""From which level on the cores' log goes to ROS."""

DIALECTS: Mapping[str, Dialect[Any, Any, Any]] = {
    Family.FORMATION.value: FORMATION,
    Family.COVERAGE.value: COVERAGE,
    Family.ASSEMBLY.value: ASSEMBLY,
}
"""How the steps of each family travel."""

logger = logging.getLogger(__name__)


class Supervision:
    """A child's view of its link: whether to stop, and for the world how far it may run."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._is_stopped = False
        self._limit = 0
        self._fallen: list[NodeId] = []
        self._pids: Mapping[NodeId, int] = {}

    def is_over(self) -> bool:
        """Return whether the orchestrator has said stop, or is gone."""
        self._link.flush()
        for record in self._link.receive():
            if isinstance(record, Stop):
                self._is_stopped = True
            elif isinstance(record, RunUntil):
                self._limit = record.tick
            elif isinstance(record, Fallen):
                self._fallen += record.nodes
            elif isinstance(record, Hosts):
                self._pids = record.pids
        return self._is_stopped or not self._link.is_open

    def may_begin(self, tick: int) -> bool:
        """Return whether a tick may start, after waiting a short while for permission."""
        if tick >= self._limit:
            self._link.wait(CREDIT_WAIT_S)
            self.is_over()
        return tick < self._limit

    def fallen(self) -> Iterable[NodeId]:
        """Return, once, the nodes whose processes have died."""
        fallen, self._fallen = self._fallen, []
        return fallen

    def computing_s(self, node: NodeId) -> float | None:
        """Return the CPU time that a node's process has used so far [s] if it computes at this moment, else None."""
        pid = self._pids.get(node)
        return computing_s(pid) if pid is not None else None

    def report(self, result: TickResult) -> None:
        """Send the account of a tick."""
        self._link.send(WorldTick(result.truth, result.answered, result.alerts, result.lost))


class WorldSupervision(Supervision):
    """The same for the world, which also shows that it is not stuck."""

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self._shown = time.monotonic()

    def is_over(self) -> bool:
        """Return whether the orchestrator has said stop, or is gone; asked several times per second."""
        now = time.monotonic()
        if now - self._shown >= ALIVE_INTERVAL_S:
            self._shown = now
            self._link.send(Alive())
        return super().is_over()


class Reporter:
    """Sends the reports of a process's agents in one record per tick."""

    def __init__(self, link: Link, robots: Collection[NodeId]) -> None:
        self._link, self._robots = link, set(robots)
        self._tick = -1
        self._reports: dict[NodeId, Any] = {}

    def take(self, robot: NodeId, outputs: AgentAnswer) -> None:
        """Take one agent's outputs; its report leaves with the last of the tick."""
        if outputs.tick != self._tick:
            self.send()
            self._tick = outputs.tick
        self._reports[robot] = outputs.report
        self._send_if_complete()

    def drop(self, robot: NodeId) -> None:
        """Wait no more for the report of a robot that has failed."""
        self._robots.discard(robot)
        self._send_if_complete()

    def send(self) -> None:
        """Send what is there, for agents of this process may have died or fallen behind."""
        if self._reports:
            self._link.send(AgentReports(self._tick, self._reports))
            self._reports = {}

    def _send_if_complete(self) -> None:
        if self._reports.keys() >= self._robots:
            self.send()


@dataclass(frozen=True, slots=True)
class Partners:
    """Topics whose other ends a process waits for before it says that it is ready.

    Attributes
    ----------
    needed : frozenset of str
        Without a partner there, nothing runs.
    overheard : frozenset of str
        Where a recorder listens beside the swarm.
    """

    needed: frozenset[str]
    overheard: frozenset[str] = frozenset()

    @classmethod
    def of(
        cls,
        robots: tuple[NodeId, ...],
        dialect: Dialect[Any, Any, Any],
        *,
        is_recorded: bool,
        has_camera: bool = False,
    ) -> Partners:
        """Return those of a process that is some robots, or the world for them, or the mission computer for none."""
        per_robot = (*dialect.sensors, *topics.ROBOT_ANSWERS)
        names = {channel.topic(robot) for robot in robots for channel in per_robot}
        names |= {topics.CAMERA_IMAGE.topic(), topics.CAMERA_INFO.topic()} if has_camera else set()
        names |= {channel.topic(MISSION) for channel in topics.MISSION_CHANNELS}
        overheard = topics.channels_by_topic(robots, dialect.sensors, dialect.shown, has_camera=has_camera)
        return cls(frozenset(names), frozenset(overheard if is_recorded else ()))


def run_world(link: Link, actors: Actors, pace: PaceConfig, *, is_recorded: bool) -> None:
    """Be the world until told to stop; one that is recorded shows viewers every tick."""
    supervision = WorldSupervision(link)
    simulation, dialect = actors.simulation(), DIALECTS[actors.family]
    try:
        with started() as executor:
            options = _view_options(is_recorded=is_recorded)
            node = WorldNode(simulation, actors.period_s, dialect, context=executor.context, **options)
            _set_up(node, executor, actors.world_config, pace)
            partners = Partners.of(
                actors.robots, dialect, is_recorded=is_recorded, has_camera=actors.image_hz is not None
            )
            if await_partners(link, executor, [node], partners, supervision.is_over):
                Lockstep(node, executor, pace, supervision).run()
    finally:
        simulation.close()


def run_mission(link: Link, actors: Actors, film_order: FilmOrder | None = None, *, is_recorded: bool) -> None:
    """Be the mission computer until told to stop."""
    forget_goals()
    supervision = Supervision(link)
    mission = actors.mission()
    with filming(film_order) as film, started() as executor:

        def report(outputs: MissionOutputs) -> None:
            link.send(MissionTick(outputs.tick, outputs.report, outputs.plan))
            film.take(mission, outputs)

        options = _view_options(is_recorded=is_recorded)
        node = MissionNode(mission, actors.period_s, report, context=executor.context, **options)
        _set_up(node, executor, actors.mission_config)
        partners = Partners.of((), DIALECTS[actors.family], is_recorded=is_recorded, has_camera=mission.has_camera)
        if await_partners(link, executor, [node], partners, supervision.is_over):
            spin_until(executor, supervision.is_over)


class AgentHost:
    """The agent nodes of one process; one that fails is taken out, and the others go on.

    Parameters
    ----------
    link : Link
    executor : Executor
    reporter : Reporter
    dialect : Dialect
        How the steps of its robots travel.
    """

    def __init__(self, link: Link, executor: Any, reporter: Reporter, dialect: Dialect[Any, Any, Any]) -> None:
        self._link, self._executor, self._reporter, self._dialect = link, executor, reporter, dialect
        self._failed: list[NodeId] = []
        self.nodes: dict[NodeId, Any] = {}

    def add(
        self, robot: NodeId, agent: AgentActor, period_s: float, config: Config, options: Mapping[str, Any]
    ) -> None:
        """Bring up the node of one robot."""
        node = AgentNode(
            agent,
            robot,
            period_s,
            lambda outputs: self._reporter.take(robot, outputs),
            lambda error: self._fail(robot, error),
            self._dialect,
            context=self._executor.context,
            **options,
        )
        _set_up(node, self._executor, config)
        self.nodes[robot] = node

    def remove_failed(self) -> None:
        """Destroy the nodes of robots that have failed; not to be called from a callback of theirs."""
        for robot in self._failed:
            node = self.nodes.pop(robot)
            self._executor.remove_node(node)
            node.destroy_node()
        self._failed.clear()

    def _fail(self, robot: NodeId, error: Exception) -> None:
        logger.error("%s failed", topics.namespace_of(robot), exc_info=error)
        self._link.send(AgentFailed(robot, reason_of(error)))
        self._reporter.drop(robot)
        self._failed.append(robot)


def run_agents(  # noqa: PLR0913 - all that a process of agents may know
    link: Link,
    agents: Mapping[NodeId, AgentActor],
    period_s: float,
    configs: Mapping[NodeId, Config],
    *,
    is_lean: bool,
    is_recorded: bool,
    family: str = Family.FORMATION.value,
) -> None:
    """Be some robots until told to stop.

    Parameters
    ----------
    link : Link
    agents : mapping of NodeId to AgentActor
        The robots of this process: each knows its number, type, settings and map. Nothing else of the scenario comes
        into a process of agents, above all no start pose and no seed.
    period_s : float
        Control period [s].
    configs : mapping of NodeId to Config
        Their settings, as their nodes declare them.
    is_lean : bool
        Whether the nodes go without parameter services and log topic.
    is_recorded : bool
        Whether a recorder listens; then viewers are shown every tick.
    family : str
        Of behavior: decides how steps travel.
    """
    forget_goals()  # a forked process would have the goals before it has heard of a plan
    supervision, reporter = Supervision(link), Reporter(link, agents)
    with started() as executor:
        host = AgentHost(link, executor, reporter, DIALECTS[family])
        options = _view_options(is_recorded=is_recorded) | (LEAN if is_lean else {})
        for robot, agent in agents.items():
            host.add(robot, agent, period_s, configs[robot], options)

        def is_over() -> bool:
            host.remove_failed()
            reporter.send()
            return supervision.is_over()

        partners = Partners.of(tuple(agents), DIALECTS[family], is_recorded=is_recorded)
        if await_partners(link, executor, [*host.nodes.values()], partners, supervision.is_over):
            spin_until(executor, is_over)


def _set_up(node: Any, executor: Any, *settings: Any) -> None:
    for config in settings:
        declare_config(node, config)
    bridge_logging(node, LOG_LEVEL)
    executor.add_node(node)


def _view_options(*, is_recorded: bool) -> dict[str, Any]:
    return {"view_period_s": 0.0} if is_recorded else {}


def await_partners(
    link: Link, executor: Any, nodes: list[Any], partners: Partners, is_over: Callable[[], bool]
) -> bool:
    """Report that this process is ready as soon as it is; return False if it was stopped before."""
    while not is_matched(nodes, partners.needed.__contains__, partners.overheard.__contains__, OWN):
        if is_over():
            return False
        spin_for(executor, MATCH_INTERVAL_S)
    link.send(Ready())
    return True
