"""One robot as a ROS node: collect a tick's messages, step, answer."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np
from rclpy.context import Context
from rclpy.node import Node

from swarm_agent.agent import Agent
from swarm_agent.config import AgentConfig
from swarm_agent.input_assembler import InputAssembler
from swarm_msgs_py import topics
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.frames import pack_batch
from swarm_msgs_py.messages.sensing import PositionFix
from swarm_msgs_py.partition import PartitionConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.ros import cdr, channels, convert, parameters, views
from swarm_msgs_py.ros.dialect import Dialect, Sense
from swarm_msgs_py.ros.formation_dialect import FORMATION
from swarm_msgs_py.ros.spin import run_node
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import NodeId, robot_name

NAME = "agent"


class Steps(Protocol):
    """What the node runs: one robot's agent."""

    def step(self, inputs: Any) -> Any:
        """Advance by one tick: from the inputs of its family to the outputs."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentIdentity(Config):
    """Which robot a node started by itself is."""

    robot: int = setting(0, "number of the robot; its namespace is /rNN", minimum=0, maximum=0xFFFD)
    type: int = setting(1, "type of the robot (table 4.1)", minimum=1, maximum=len(THESIS_TYPES))
    period_s: float = setting(0.5, "control period", unit="s", minimum=0.05, maximum=1.0)
    start_x_m: float = setting(0.0, "where the robot stands at the start, with start_sigma_m", unit="m")
    start_y_m: float = setting(0.0, "where the robot stands at the start, with start_sigma_m", unit="m")
    start_sigma_m: float = setting(
        0.0, "standard deviation of that, per axis; 0: the start is not known", unit="m", minimum=0.0
    )
    partition: PartitionConfig = section(
        PartitionConfig, "how to find the goals that a plan leaves to the robots: as the mission computer has it"
    )

    @property
    def start(self) -> PositionFix | None:
        """What the robot was told of its start point."""
        if self.start_sigma_m == 0.0:
            return None
        return PositionFix(np.array([self.start_x_m, self.start_y_m]), self.start_sigma_m)


class AgentNode(Node):
    """ROS face of one agent.

    Parameters
    ----------
    agent : Steps
    robot : NodeId
        Decides the namespace; the node touches nothing outside it.
    period_s : float
        Control period [s].
    on_step : callable or None
        Is handed what the agent answered, after it was sent.
    dialect : Dialect
        How its family's inputs and commands travel.
    on_failure : callable or None
        Is handed what the agent, or sending its answer, raised; from then on the node keeps silent, until its owner
        destroys it. None lets the exception end the process, as is right for a robot that has it to itself.
    view_period_s : float
        Wall time between two messages for viewers [s]; 0: one in every tick.
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(  # noqa: PLR0913, PLR0917 - whom it runs, how it talks, and who wants to know
        self,
        agent: Steps,
        robot: NodeId,
        period_s: float,
        on_step: Callable[[Any], None] | None = None,
        on_failure: Callable[[Exception], None] | None = None,
        dialect: Dialect[Any, Any, Any] = FORMATION,
        *,
        view_period_s: float = views.VIEW_PERIOD_S,
        **options: Any,
    ) -> None:
        super().__init__(NAME, namespace=robot_name(robot), **options)
        self._agent, self._robot, self._period = agent, robot, period_s
        self._on_step, self._on_failure, self._has_failed = on_step, on_failure, False
        self._dialect = dialect
        self._assembler = InputAssembler(period_s, dialect.join, dialect.required)
        self._command = channels.publisher(self, topics.CMD_VEL, robot)
        self._radio = channels.publisher(self, topics.RADIO_TX, robot)
        self._views = [(views.View(self, channel, robot, view_period_s), make) for channel, make in dialect.views]
        for sense in dialect.senses:
            self._listen_to(sense)
        self._listen(topics.RADIO_RX, convert.decode_frames, self._assembler.put_batch)

    def _listen_to(self, sense: Sense[Any]) -> None:
        decode, part, put = sense.decode, sense.part, self._assembler.put
        self._listen(sense.channel, lambda data: decode(data, self._period), lambda m: put(part, m[0], m[1]))

    def _listen(
        self, channel: topics.Channel, decode: Callable[[bytes], Any], put: Callable[[Any], Any | None]
    ) -> None:
        def take(record: Any) -> None:
            if self._has_failed:
                return
            try:
                inputs = put(record)
                if inputs is not None:  # the tick is complete
                    self._answer(self._agent.step(inputs))
            except Exception as error:
                if self._on_failure is None:
                    raise
                self._has_failed = True
                self._on_failure(error)

        channels.decoded_subscription(self, channel, decode, take, self._robot)

    def _answer(self, outputs: Any) -> None:
        seconds = outputs.tick * self._period
        self._command.publish(self._dialect.encode_command(cdr.stamp(seconds), self._robot, outputs.command))
        self._radio.publish(convert.encode_batch(pack_batch(outputs.tick, Parts.NONE, outputs.outbox)))
        if self._on_step is not None:
            self._on_step(outputs)
        for view, make in self._views:
            view.show(partial(make, self._robot, seconds, outputs.report))


def _from_parameters(context: Context) -> AgentNode:
    """Make the node of the robot that the process's parameters describe."""
    with parameters.reader(NAME, context) as reader:
        identity = parameters.declare_config(reader, AgentIdentity())
        config = parameters.declare_config(reader, AgentConfig())
    robot = NodeId(identity.robot)
    kind, tuning = THESIS_TYPES[identity.type - 1], identity.partition
    agent = Agent(robot, config, kind, identity.period_s, start=identity.start, partition=tuning)
    node = AgentNode(agent, robot, identity.period_s, context=context)
    parameters.declare_config(node, identity)
    parameters.declare_config(node, config)
    return node


def main(args: Sequence[str] | None = None) -> None:
    """Run one robot's node: ``ros2 run swarm_agent agent_node --ros-args -p robot:=3``."""
    sys.exit(run_node(_from_parameters, args))
