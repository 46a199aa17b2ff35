"""One robot as a ROS node: collect a tick's messages, step, answer."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
from swarm_msgs_py.messages.report import AgentReport
from swarm_msgs_py.messages.sensing import PositionFix
from swarm_msgs_py.partition import PartitionConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.ros import cdr, channels, convert, parameters, views
from swarm_msgs_py.ros.spin import run_node
from swarm_msgs_py.step_io import AgentInputs, AgentOutputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import NodeId, robot_name

NAME = "agent"


class Steps(Protocol):
    """What the node runs: one robot's agent."""

    def step(self, inputs: AgentInputs) -> AgentOutputs:
        """Advance by one tick."""
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
    on_failure : callable or None
        Is handed what the agent, or sending its answer, raised; from then on the node keeps silent, until its owner
        destroys it. None lets the exception end the process, as is right for a robot that has it to itself.
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(
        self,
        agent: Steps,
        robot: NodeId,
        period_s: float,
        on_step: Callable[[AgentOutputs], None] | None = None,
        on_failure: Callable[[Exception], None] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(NAME, namespace=robot_name(robot), **options)
        self._agent, self._robot, self._period = agent, robot, period_s
        self._on_step, self._on_failure, self._has_failed = on_step, on_failure, False
        self._frame = convert.body_frame(robot)
        self._assembler = InputAssembler(period_s)
        self._command = channels.publisher(self, topics.CMD_VEL, robot)
        self._radio = channels.publisher(self, topics.RADIO_TX, robot)
        self._odom, self._path, self._status = (views.View(self, view, robot) for view in topics.ROBOT_VIEWS)
        put, at = self._assembler, self._tick_at
        self._listen(topics.IMU, convert.decode_imu, lambda m: put.put_imu(at(m[0]), m[1]))
        self._listen(topics.FIX, convert.decode_fix, lambda m: put.put_fix(at(m[0]), m[1]))
        self._listen(topics.RANGES, convert.decode_ranges, lambda m: put.put_ranges(*m))
        self._listen(topics.PROXIMITY, convert.decode_proximity, lambda m: put.put_proximity(at(m[0]), m[1]))
        self._listen(topics.RADIO_RX, convert.decode_frames, put.put_batch)

    def _listen(
        self, channel: topics.Channel, decode: Callable[[bytes], Any], put: Callable[[Any], AgentInputs | None]
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

    def _answer(self, outputs: AgentOutputs) -> None:
        seconds = outputs.tick * self._period
        self._command.publish(convert.encode_command(cdr.stamp(seconds), self._frame, outputs.command))
        self._radio.publish(convert.encode_batch(pack_batch(outputs.tick, Parts.NONE, outputs.outbox)))
        if self._on_step is not None:
            self._on_step(outputs)
        self._show(seconds, outputs.report)

    def _show(self, seconds: float, report: AgentReport) -> None:
        self._odom.show(lambda: views.odometry(self._robot, seconds, report))
        self._path.show(lambda: views.path(seconds, report))
        self._status.show(lambda: views.status(self._robot, seconds, report))

    def _tick_at(self, seconds: float) -> int:
        return convert.tick_at(seconds, self._period)


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
