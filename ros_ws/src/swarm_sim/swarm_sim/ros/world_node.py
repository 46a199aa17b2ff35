"""The simulated world as a ROS node: publish what everybody senses, collect what everybody does."""

from __future__ import annotations

import logging
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.task import Future
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool, Trigger

from swarm_msgs_py import topics
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.frames import Batch, pack_batch
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.ros import camera, cdr, channels, convert, parameters, views
from swarm_msgs_py.ros.dialect import Dialect
from swarm_msgs_py.ros.formation_dialect import FORMATION
from swarm_msgs_py.ros.log_bridge import bridge_logging
from swarm_msgs_py.ros.spin import run_with_ros
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import MISSION, NodeId, robot_name
from swarm_sim.answers import AnswerBook, Answers
from swarm_sim.config import SimConfig
from swarm_sim.electronics import arrival_line, death_line
from swarm_sim.ros.lockstep import Lockstep, PaceConfig, Switched, TickResult
from swarm_sim.scene import RobotSpec, Scene
from swarm_sim.simulation import Simulation
from swarm_sim.ticked_world import TickedWorld, Truth

NAME, NAMESPACE = "world", "world"

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldIdentity(Config):
    """What stands in a world that is started by itself: robots in rows, no obstacles."""

    counts: tuple[int, ...] = setting((3,), "number of robots of each type (table 4.1)", minimum=0, maximum=1000)
    spacing_m: float = setting(2.0, "distance between robots at the start", unit="m", minimum=1.0, maximum=20.0)
    bounds_m: float = setting(50.0, "half the side of the square arena", unit="m", above=0.0)
    seed: int = setting(0, "seed of the run", minimum=0)


class WorldNode(Node):
    """ROS face of the simulation. A tick is `begin`, callbacks until `answered` is done, `finish`.

    Parameters
    ----------
    simulation : TickedWorld
    period_s : float
        Control period [s].
    dialect : Dialect
        How its robots' inputs and commands travel.
    view_period_s : float
        Wall time between two messages for viewers [s]; 0: one in every tick.
    **options
        Of `rclpy.node.Node`.

    Attributes
    ----------
    answered : Future
        Done as soon as nobody is left to wait for in this tick.
    is_paused : bool
        Whether the operator holds simulated time.
    period_s : float
        Control period [s].
    """

    def __init__(
        self,
        simulation: TickedWorld,
        period_s: float,
        dialect: Dialect[Any, Any, Any] = FORMATION,
        *,
        view_period_s: float = views.VIEW_PERIOD_S,
        **options: Any,
    ) -> None:
        super().__init__(NAME, namespace=NAMESPACE, **options)
        self._simulation, self.period_s, self._dialect = simulation, period_s, dialect
        self._book = AnswerBook(node for node in (*simulation.robots, MISSION) if node not in self.off)
        self._switched: list[Switched] = []
        self._fallen: set[NodeId] = set()  # whose process is gone
        self._is_mission_on = True
        self.answered, self.is_paused = Future(), False
        self._clock_topic = channels.publisher(self, topics.CLOCK)
        self._truth = views.View(self, topics.TRUTH, period_s=view_period_s)
        self._robots = views.View(self, topics.ROBOT_MARKERS, period_s=view_period_s)
        self._sensors = {
            robot: tuple(channels.publisher(self, channel, robot) for channel in dialect.sensors)
            for robot in simulation.robots
        }
        self._mission_rx = channels.publisher(self, topics.RADIO_RX, MISSION)
        self._images: Publisher | None = None
        if simulation.camera_info is not None:
            self._images = channels.publisher(self, topics.CAMERA_IMAGE)
            self._camera_info = channels.publisher(self, topics.CAMERA_INFO)
        for robot in simulation.robots:
            self._listen(topics.CMD_VEL, dialect.decode_command, self._take_command, robot)
        for node in (*simulation.robots, MISSION):
            self._listen(topics.RADIO_TX, convert.decode_frames, self._take_frames, node)
        channels.subscription(self, topics.KILL_ROBOT, lambda message: self._take_kill(message.data))
        for robot in simulation.robots:
            self.create_service(SetBool, topics.power_service(robot), partial(self._take_power, robot))
        self.create_service(Trigger, topics.PAUSE_SERVICE, lambda _, reply: self._hold(True, reply))
        self.create_service(Trigger, topics.RESUME_SERVICE, lambda _, reply: self._hold(False, reply))

    @property
    def tick(self) -> int:
        """Number of the current tick."""
        return self._simulation.tick

    @property
    def off(self) -> tuple[NodeId, ...]:
        """Robots whose electronics are off, ascending."""
        return tuple(robot for robot in self._simulation.robots if not self._simulation.is_on(robot))

    @property
    def missing(self) -> tuple[NodeId, ...]:
        """Who has not answered the current tick yet."""
        return self._book.missing

    @property
    def is_deserted(self) -> bool:
        """Whether the whole swarm is silent, so that there is nobody to wait for."""
        return self._book.is_deserted

    def begin(self) -> None:
        """Publish everything that belongs to the current tick."""
        seen = self._simulation.observe()
        for node in self._simulation.take_died():
            self._switched.append(Switched(node, False, death_line(node)))
            self._book.remove(node)
            self._is_mission_on &= node != MISSION
        for node in self._simulation.take_arrived():
            if node in self._fallen:
                self._simulation.kill(node)
                continue
            self._switched.append(Switched(node, True, arrival_line(node)))
            self._book.add(node)
        self.answered = Future()
        self._book.open(seen.tick, frozenset(seen.agents) | {MISSION})
        stamp = cdr.stamp(seen.time)
        self._clock_topic.publish(Clock(clock=views.time_message(seen.time)))
        if self._is_mission_on:
            self._publish_to_mission(seen.mission)  # first, for the plan takes it longest
        for robot, inputs in seen.agents.items():
            self._publish_senses(robot, stamp, inputs)
        self._check()

    def finish(self) -> tuple[Truth, Answers]:
        """Apply what was answered, let the bodies move, and return what happened."""
        answers = self._book.close()
        self._simulation.apply(answers.commands, answers.outboxes)
        truth = self._simulation.advance()
        self._truth.show(lambda: views.poses(truth.time, truth.positions, truth.yaws))
        simulation, alive = self._simulation, truth.alive.tolist()
        self._robots.show(
            lambda: views.robot_markers(truth.time, truth.positions, simulation.radii, alive, simulation.links)
        )
        return truth, answers

    def bury(self, node: NodeId) -> None:
        """Take a robot or the mission computer out of the run for good: its process is gone."""
        if node not in self._fallen:
            self._fallen.add(node)
            self._switch_off(node)

    def take_switched(self) -> tuple[Switched, ...]:
        """Return, once, who was switched off or on, by the scenario or the operator."""
        switched, self._switched = tuple(self._switched), []
        return switched

    def _switch_off(self, node: NodeId) -> None:
        self._simulation.kill(node)
        self._book.remove(node)
        self._check()

    def _publish_to_mission(self, inputs: MissionInputs) -> None:
        parts = Parts.NONE if inputs.image is None else Parts.IMAGE
        self._mission_rx.publish(convert.encode_batch(pack_batch(inputs.tick, parts, inputs.inbox)))
        if inputs.image is not None and inputs.camera is not None and self._images is not None:
            self._camera_info.publish(camera.info_message(inputs.camera, views.time_message(inputs.image.time)))
            self._images.publish(camera.encode_image(inputs.image))

    def _publish_senses(self, robot: NodeId, stamp: bytes, inputs: Any) -> None:
        """Publish what a robot senses, as far as there is anything to say."""
        *sensors, radio = self._sensors[robot]
        parts = 0
        for sense, publisher in zip(self._dialect.senses, sensors, strict=True):
            if sense.is_there(inputs) or (sense.tells_viewers and publisher.get_subscription_count() > 1):
                parts |= sense.part
                publisher.publish(sense.encode(stamp, robot, inputs))
        radio.publish(convert.encode_batch(pack_batch(inputs.tick, parts, inputs.inbox)))

    def _listen(
        self,
        channel: topics.Channel,
        decode: Callable[[bytes], Any],
        take: Callable[[NodeId, Any], None],
        node: NodeId,
    ) -> None:
        channels.decoded_subscription(self, channel, decode, lambda record: take(node, record), node)

    def _take_command(self, robot: NodeId, stamped: tuple[float, Any]) -> None:
        seconds, command = stamped
        self._book.put_command(robot, convert.tick_at(seconds, self.period_s), command)
        self._check()

    def _take_frames(self, node: NodeId, batch: Batch) -> None:
        self._book.put_frames(node, batch.tick, batch.frames)
        self._check()

    def _take_kill(self, number: int) -> None:
        if number not in self._simulation.robots:
            logger.warning("%s: there is no robot %d", topics.KILL_ROBOT.topic(), number)
            return
        self._kill(NodeId(number))

    def _kill(self, robot: NodeId) -> None:
        self._switched.append(Switched(robot, False, f"{robot_name(robot)} was killed by the operator"))
        self._switch_off(robot)

    def _take_power(self, robot: NodeId, request: SetBool.Request, reply: SetBool.Response) -> SetBool.Response:
        """Switch a robot off or on; one that is switched on takes part from the next tick on."""
        name, is_on = robot_name(robot), self._simulation.is_on(robot)
        reply.success = request.data != is_on and robot not in self._fallen
        reply.message = f"{name} is {'on' if request.data else 'off'} from tick {self.tick} on"
        if robot in self._fallen:
            reply.message = f"the process of {name} is gone; start the run again"
        elif request.data == is_on:
            reply.message = f"{name} is {'on' if is_on else 'off'} already"
        elif request.data:
            self._switched.append(Switched(robot, True, f"{name} was switched on by the operator"))
            self._simulation.revive(robot)
            self._book.add(robot)
        else:
            self._kill(robot)
        return reply

    def _hold(self, is_paused: bool, reply: Trigger.Response) -> Trigger.Response:
        self.is_paused = is_paused
        reply.success = True
        reply.message = f"simulated time {'stands' if is_paused else 'runs'} at tick {self.tick}"
        return reply

    def _check(self) -> None:
        if self._book.is_complete and not self.answered.done():
            self.answered.set_result(None)


class _Unattended:
    """Lets a world that was started by itself run until ROS is shut down."""

    def is_over(self) -> bool:
        return False

    def may_begin(self, tick: int) -> bool:  # noqa: ARG002 - part of the protocol
        return True

    def fallen(self) -> Iterable[NodeId]:
        return ()

    def computing_s(self, node: NodeId) -> float | None:  # noqa: ARG002 - its process may be on another machine
        return None

    def report(self, result: TickResult) -> None:
        for alert in result.alerts:
            logger.warning(alert)


def _scene(identity: WorldIdentity) -> Scene:
    kinds = [kind for kind, count in zip(THESIS_TYPES, identity.counts, strict=False) for _ in range(count)]
    columns = max(1, math.isqrt(len(kinds)))
    places = [(number % columns - columns / 2, number // columns + 1) for number in range(len(kinds))]
    robots = tuple(
        RobotSpec(NodeId(number), kind, (x * identity.spacing_m, y * identity.spacing_m), 0.0, True)
        for number, (kind, (x, y)) in enumerate(zip(kinds, places, strict=True))
    )
    half = identity.bounds_m
    return Scene(robots, (), (-half, -half, half, half), (0.0, 0.0))


def _run(executor: Executor) -> None:
    """Run the world that the process's parameters describe."""
    with parameters.reader(NAME, executor.context) as reader:
        identity = parameters.declare_config(reader, WorldIdentity())
        config = parameters.declare_config(reader, SimConfig())
        pace = parameters.declare_config(reader, PaceConfig())
    simulation = Simulation(config, _scene(identity), identity.seed)
    try:
        node = WorldNode(simulation, config.period_s, context=executor.context)
        for settings in (identity, config, pace):
            parameters.declare_config(node, settings)
        bridge_logging(node)
        executor.add_node(node)
        Lockstep(node, executor, pace, _Unattended()).run()
    finally:
        simulation.close()


def main(args: Sequence[str] | None = None) -> None:
    """Run the world's node: ``ros2 run swarm_sim world_node --ros-args -p counts:=[2,1]``."""
    sys.exit(run_with_ros(_run, args))
