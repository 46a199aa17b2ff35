"""The mission computer as a ROS node: frames and the operator's shape in, frames and the plan out."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from geometry_msgs.msg import PolygonStamped
from rclpy.context import Context
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo

from mission_computer.config import MissionConfig
from mission_computer.input_assembler import InputAssembler
from mission_computer.mission import Mission
from mission_computer.shape import Placement, is_drawing, placed_shape, with_room
from swarm_msgs_py import topics
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.frames import Batch, pack_batch
from swarm_msgs_py.markers import CoverMarker, MarkerColor
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera import CameraImage, ImageArray
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.plan_course import Course
from swarm_msgs_py.plan_motion import goals_at
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.ros import camera, cdr, channels, convert, parameters, views
from swarm_msgs_py.ros.spin import run_node
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.step_io import MissionInputs, MissionOutputs
from swarm_msgs_py.topics import Parts
from swarm_msgs_py.types import MISSION, FloatArray, NodeId

_log = logging.getLogger(__name__)

NAME, NAMESPACE = "mission_computer", "mission"


class Steps(Protocol):
    """What the node runs: the mission computer."""

    @property
    def has_camera(self) -> bool:
        """Whether it looks at the robots from above."""
        ...

    def step(self, inputs: MissionInputs) -> MissionOutputs:
        """Advance by one tick."""
        ...

    def picture(self) -> ImageArray | None:
        """Return the last image with what was read out of it; None if there was none."""
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionIdentity(Config):
    """What a mission computer node started by itself is to do."""

    shape: str = setting("hw_2_square", "shape to form: library name, file, text:TEXT or points")
    room_m2: float = setting(
        6.0,
        "a shape in meters is made this large per robot; 0: it is as large as it is; drawings and texts become as "
        "large as robots need",
        unit="m^2",
        minimum=0.0,
    )
    counts: tuple[int, ...] = setting((3,), "number of robots of each type (table 4.1)", minimum=0, maximum=1000)
    period_s: float = setting(0.5, "control period", unit="s", minimum=0.05, maximum=1.0)
    colors: str = setting("", "colors of the robots' covers in their order, e.g. red,blue; none: there is no camera")
    cover_radii_m: tuple[float, ...] = setting(
        (0.16, 0.11, 0.11, 0.08, 0.08), "radii of those covers (table 5.1)", unit="m", above=0.0, maximum=10.0
    )

    def __post_init__(self) -> None:
        """Check that every count has its type, and every robot under a camera its cover.

        Raises
        ------
        ConfigError
            If there are more counts than types, or covers do not fit the robots.
        """
        Config.__post_init__(self)
        if len(self.counts) > len(THESIS_TYPES):
            raise ConfigError(f"counts must name at most {len(THESIS_TYPES)} types, got {len(self.counts)}")
        if self.colors and not len(self._names) == len(self.cover_radii_m) == sum(self.counts):
            raise ConfigError(
                f"colors and cover_radii_m must name one cover for each of the {sum(self.counts)} robots of counts, "
                f"got {len(self._names)} colors and {len(self.cover_radii_m)} radii"
            )
        known = [color.value for color in MarkerColor]
        for number, name in enumerate(self._names):
            if name not in known or name in self._names[:number]:
                raise ConfigError(f"colors: '{name}' is not one of {', '.join(known)}, or named twice")

    @property
    def _names(self) -> list[str]:
        return [name.strip() for name in self.colors.split(",")] if self.colors else []

    @property
    def covers(self) -> tuple[CoverMarker, ...]:
        """Return by what an overhead camera knows each robot; none if there is no camera."""
        worn = zip(self._names, self.cover_radii_m, strict=False)
        return tuple(
            CoverMarker(robot=NodeId(robot), color=MarkerColor(name), radius=radius)
            for robot, (name, radius) in enumerate(worn)
        )


class MissionNode(Node):
    """ROS face of the mission computer.

    Parameters
    ----------
    mission : Steps
    period_s : float
        Control period [s].
    on_step : callable or None
        Is handed what the mission computer answered, after it was sent.
    view_period_s : float, optional
        Least wall time between two pictures for viewers [s].
    **options
        Of `rclpy.node.Node`.
    """

    def __init__(
        self,
        mission: Steps,
        period_s: float,
        on_step: Callable[[MissionOutputs], None] | None = None,
        *,
        view_period_s: float = views.VIEW_PERIOD_S,
        **options: Any,
    ) -> None:
        super().__init__(NAME, namespace=NAMESPACE, **options)
        self._mission, self._period, self._on_step = mission, period_s, on_step
        self._ordered: FloatArray | None = None
        self._course = Course()
        self._radio = channels.publisher(self, topics.RADIO_TX, MISSION)
        self._goals = channels.publisher(self, topics.GOALS)
        self._markers = channels.publisher(self, topics.MARKERS)
        self._assembler = InputAssembler(period_s, self._take_order)
        self._picture = views.View(self, topics.CAMERA_VIEW, period_s=view_period_s) if mission.has_camera else None
        channels.subscription(self, topics.SHAPE, self._take_shape)
        if mission.has_camera:
            channels.subscription(self, topics.CAMERA_INFO, self._take_info)
            channels.decoded_subscription(self, topics.CAMERA_IMAGE, camera.decode_image, self._take_image)
        channels.decoded_subscription(self, topics.RADIO_RX, convert.decode_frames, self._take_batch, MISSION)

    def _take_shape(self, message: PolygonStamped) -> None:
        self._ordered = np.array([[point.x, point.y] for point in message.polygon.points]).reshape(-1, 2)

    def _take_order(self) -> FloatArray | None:
        ordered, self._ordered = self._ordered, None
        return ordered

    def _take_info(self, message: CameraInfo) -> None:
        try:
            info = camera.info_of(message)
        except cdr.MessageError as error:
            _log.warning("%s: message dropped: %s", topics.CAMERA_INFO.topic(), error)
            return
        self._step(self._assembler.put_info(info))

    def _take_image(self, image: CameraImage) -> None:
        self._step(self._assembler.put_image(convert.tick_at(image.time, self._period), image))

    def _take_batch(self, batch: Batch) -> None:
        self._step(self._assembler.put_batch(batch))

    def _step(self, inputs: MissionInputs | None) -> None:
        """Answer a tick, if it is complete."""
        if inputs is None:
            return
        outputs = self._mission.step(inputs)
        self._radio.publish(convert.encode_batch(pack_batch(outputs.tick, Parts.NONE, outputs.outbox)))
        if self._on_step is not None:
            self._on_step(outputs)
        if self._picture is not None and outputs.report.camera is not None:
            self._picture.show(lambda: self._drawn(inputs.time))
        if outputs.plan is not None:
            self._course.put(inputs.tick, outputs.plan)
        elif not self._course.is_changing(inputs.tick):
            return
        self._show(inputs.time, self._course.at(inputs.tick), inputs.tick)

    def _drawn(self, seconds: float) -> bytes:
        picture = self._mission.picture()
        assert picture is not None  # only asked after an image
        return camera.encode_image(CameraImage(seconds, picture))

    def _show(self, seconds: float, plan: Plan, tick: int) -> None:
        """Tell viewers where the shape is; while it moves, in every tick."""
        self._goals.publish(views.poses(seconds, goals_at(plan, tick), np.zeros(len(plan.goals))))
        self._markers.publish(views.plan_markers(seconds, plan, tick))


def _from_parameters(context: Context) -> MissionNode:
    """Make the node that the process's parameters describe, for a field without obstacles."""
    with parameters.reader(NAME, context) as reader:
        identity = parameters.declare_config(reader, MissionIdentity())
        config = parameters.declare_config(reader, MissionConfig())
        network = parameters.declare_config(reader, NetworkConfig())
    roster = Roster.of(kind for kind, count in zip(THESIS_TYPES, identity.counts, strict=False) for _ in range(count))
    placement = Placement(area=None if is_drawing(identity.shape) else identity.room_m2 * roster.size or None)
    shape = placed_shape(identity.shape, with_room(identity.shape, placement, roster, config.partition))
    mission = Mission(config, network, roster, (), shape, identity.period_s, markers=identity.covers)
    node = MissionNode(mission, identity.period_s, context=context)
    for settings in (identity, config, network):
        parameters.declare_config(node, settings)
    return node


def main(args: Sequence[str] | None = None) -> None:
    """Run the mission computer's node: ``ros2 run mission_computer mission_node``."""
    sys.exit(run_node(_from_parameters, args))
