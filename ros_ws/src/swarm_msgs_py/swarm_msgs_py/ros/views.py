"""Messages for people who look: rviz, Foxglove, ``ros2 topic echo``. Nothing in the swarm reads them.

They are built from nested message objects, which is slow, so a `View` builds one only while somebody subscribes, and
not more often than a person can look.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, Quaternion
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from swarm_msgs_py.assembly.boat_io import AssemblyReport
from swarm_msgs_py.coverage_io import CoverageReport
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import AgentReport, Mode, Positioning
from swarm_msgs_py.orientation import quaternion_of
from swarm_msgs_py.plan_motion import contour_at, goals_at
from swarm_msgs_py.ros.cdr import NANO
from swarm_msgs_py.ros.channels import publisher
from swarm_msgs_py.ros.convert import MAP_FRAME, body_frame
from swarm_msgs_py.topics import Channel, namespace_of
from swarm_msgs_py.types import FloatArray, NodeId, robot_name

VIEW_PERIOD_S = 0.1  # wall time between two messages of one view

CONTOUR_COLOR = ColorRGBA(r=0.1, g=0.6, b=0.2, a=1.0)
OBSTACLE_COLOR = ColorRGBA(r=0.5, g=0.5, b=0.5, a=1.0)
GOAL_COLOR = ColorRGBA(r=0.9, g=0.6, b=0.1, a=1.0)
ROBOT_COLOR, OFF_COLOR = ColorRGBA(r=0.0, g=0.45, b=0.7, a=1.0), ColorRGBA(r=0.6, g=0.6, b=0.6, a=1.0)
LINK_COLOR = ColorRGBA(r=0.3, g=0.5, b=0.65, a=0.5)
ROBOT_HEIGHT_M, LINK_WIDTH_M = 0.2, 0.03
LINE_WIDTH_M, GOAL_SIZE_M = 0.1, 0.3


class View:
    """A topic for viewers.

    Parameters
    ----------
    node : Node
    channel : Channel
    address : NodeId or None
        Whose topic, where each node has its own.
    period_s : float
        Wall time between two messages [s]; 0 shows everything, as a recorder wants it.
    """

    def __init__(
        self, node: Node, channel: Channel, address: NodeId | None = None, period_s: float = VIEW_PERIOD_S
    ) -> None:
        self._publisher = publisher(node, channel, address)
        self._period = period_s
        self._due = -math.inf

    def show(self, make: Callable[[], Any]) -> None:
        """Publish what `make` returns, if somebody looks and has not just been shown."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + self._period
        if self._publisher.get_subscription_count():
            self._publisher.publish(make())


def time_message(seconds: float) -> Time:
    """Return simulated time [s] as a message."""
    whole, nanoseconds = divmod(round(seconds * NANO), NANO)
    return Time(sec=whole, nanosec=nanoseconds)


def odometry(robot: NodeId, seconds: float, report: AgentReport) -> Odometry:
    """Return a robot's own estimate with its covariance."""
    message = Odometry(header=_header(seconds), child_frame_id=body_frame(robot))
    message.pose.pose = _pose(report.position, report.yaw)
    covariance = np.zeros((6, 6))
    covariance[:2, :2] = report.covariance
    message.pose.covariance = covariance.ravel()
    cos, sin = math.cos(report.yaw), math.sin(report.yaw)
    east, north = report.velocity.tolist()  # a twist is in the child frame
    message.twist.twist.linear.x, message.twist.twist.linear.y = cos * east + sin * north, cos * north - sin * east
    return message


def path(robot: NodeId, seconds: float, report: AgentReport) -> Path:  # noqa: ARG001 - of a family of views
    """Return where a robot means to drive: its own position, then the way-points."""
    header = _header(seconds)
    points = [report.position, *report.path]
    return Path(header=header, poses=[PoseStamped(header=header, pose=_pose(point, 0.0)) for point in points])


def status(robot: NodeId, seconds: float, report: AgentReport) -> DiagnosticArray:
    """Return a robot's mode, goal, neighbors and frame counts; not well while it does not know where it is."""
    counters, localization = report.counters, report.localization
    values = {
        "mode": report.mode.name.lower(),
        "positioning": localization.positioning.name.lower(),
        "lost_by_beacons": localization.lost_by_beacons,
        "lost_by_sigma": localization.lost_by_sigma,
        "position_sigma_m": f"{math.sqrt(float(np.trace(report.covariance)) / 2.0):.3f}",
        "shared_error": f"{localization.shared:.2f}",
        "ranges_accepted": localization.accepted,
        "ranges_rejected": localization.rejected,
        "beacon_disagreements": localization.disagreements,
        "epoch": report.epoch,
        "goal": report.goal,
        "neighbors": " ".join(namespace_of(neighbor) for neighbor in report.neighbors),
        "beacons": report.beacons,
        "routes": report.routes,
        "rows": report.rows,
        "goals_crc": f"{report.goals_crc:08x}",
        "frames_sent": counters.frames_sent,
        "frames_heard": counters.frames_heard,
        "bytes_sent": counters.bytes_sent,
        "bytes_heard": counters.bytes_heard,
        "frames_corrupt": counters.corrupt,
        "packets_unroutable": counters.unroutable,
    }
    is_well = report.mode is not Mode.WAITING and localization.positioning is Positioning.LOCALIZED
    state = DiagnosticStatus(
        level=DiagnosticStatus.OK if is_well else DiagnosticStatus.WARN,
        name=robot_name(robot),
        hardware_id=robot_name(robot),
        message=report.mode.name.lower(),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
    return DiagnosticArray(header=_header(seconds), status=[state])


def point_odometry(robot: NodeId, seconds: float, report: CoverageReport) -> Odometry:
    """Return where a point robot believes to be; the origin as long as it does not know."""
    message = Odometry(header=_header(seconds), child_frame_id=body_frame(robot))
    message.pose.pose = _pose(np.zeros(3) if report.position is None else report.position, 0.0)
    return message


def point_path(robot: NodeId, seconds: float, report: CoverageReport) -> Path:  # noqa: ARG001 - of a family of views
    """Return where a point robot means to drive: its own position, then its place."""
    header = _header(seconds)
    points = [point for point in (report.position, report.target) if point is not None]
    return Path(header=header, poses=[PoseStamped(header=header, pose=_pose(point, 0.0)) for point in points])


def point_status(robot: NodeId, seconds: float, report: CoverageReport) -> DiagnosticArray:
    """Return what a point robot does and knows."""
    values = {
        "mode": report.mode.name.lower(),
        "hops": report.hops,
        "places": report.places,
        "is_done": report.is_done,
        "is_leading": report.is_leading,
    }
    state = DiagnosticStatus(
        level=DiagnosticStatus.OK,
        name=robot_name(robot),
        hardware_id=robot_name(robot),
        message=report.mode.name.lower(),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
    return DiagnosticArray(header=_header(seconds), status=[state])


def boat_odometry(robot: NodeId, seconds: float, report: AssemblyReport) -> Odometry:
    """Return where a boat measured itself."""
    message = Odometry(header=_header(seconds), child_frame_id=body_frame(robot))
    message.pose.pose = _pose(report.pose[:2], float(report.pose[2]))
    return message


def boat_path(robot: NodeId, seconds: float, report: AssemblyReport) -> Path:  # noqa: ARG001 - of a family of views
    """Return where a boat is driving: its own place, then the middle of a cell."""
    header = _header(seconds)
    points = (report.pose[:2], report.goal)
    return Path(header=header, poses=[PoseStamped(header=header, pose=_pose(point, 0.0)) for point in points])


def boat_status(robot: NodeId, seconds: float, report: AssemblyReport) -> DiagnosticArray:
    """Return what a boat does, and what it touches."""
    values = {
        "mode": report.mode.name.lower(),
        "epoch": report.epoch,
        "steps": f"{report.steps_done} of {report.steps}",
        "contacts": " ".join(face.name.lower() for face in sorted(report.contacts)),
    }
    state = DiagnosticStatus(
        level=DiagnosticStatus.OK,
        name=robot_name(robot),
        hardware_id=robot_name(robot),
        message=report.mode.name.lower(),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
    return DiagnosticArray(header=_header(seconds), status=[state])


def poses(seconds: float, positions: FloatArray, yaws: Iterable[float]) -> PoseArray:
    """Return poses in the world frame, for (n, 2) or (n, 3) positions [m] and n headings [rad]."""
    posed = [_pose(position, yaw) for position, yaw in zip(positions, yaws, strict=True)]
    return PoseArray(header=_header(seconds), poses=posed)


def plan_markers(seconds: float, plan: Plan, tick: int) -> MarkerArray:
    """Return the plan's contour and goals, as they are at a tick, and its obstacles as markers."""
    header = _header(seconds)
    lines = [_outline(header, "contour", 0, contour_at(plan, tick), CONTOUR_COLOR)]
    lines += [_outline(header, "obstacles", k, corners, OBSTACLE_COLOR) for k, corners in enumerate(plan.obstacles)]
    places = _points(goals_at(plan, tick))
    goals = Marker(header=header, ns="goals", type=Marker.SPHERE_LIST, color=GOAL_COLOR, points=places)
    goals.pose.orientation.w = 1.0
    goals.scale.x = goals.scale.y = goals.scale.z = GOAL_SIZE_M
    # What an earlier plan left on the screen goes first.
    return MarkerArray(markers=[Marker(header=header, action=Marker.DELETEALL), *lines, goals])


def robot_markers(
    seconds: float, positions: FloatArray, radii: FloatArray, alive: Sequence[bool], links: Sequence[tuple[int, int]]
) -> MarkerArray:
    """Return robots as the discs that cover them, those whose electronics are off gray, and radio links as lines.

    Parameters
    ----------
    seconds : float
        Simulated time [s].
    positions : (n, 2) or (n, 3) array
        True positions [m]; robots on the plane stand on it.
    radii : (n,) array
        Coverage radii [m].
    alive : sequence of bool
        Whose electronics work.
    links : sequence of (int, int)
        Rows of robots that hear each other.
    """
    header, markers = _header(seconds), []
    places = positions
    if positions.shape[1] == 2:
        places = np.column_stack([positions, np.full(len(positions), ROBOT_HEIGHT_M / 2.0)])
    for row, ((x, y, z), radius, is_alive) in enumerate(zip(places.tolist(), radii.tolist(), alive, strict=True)):
        marker = Marker(header=header, ns="robots", id=row, type=Marker.CYLINDER)
        marker.color = ROBOT_COLOR if is_alive else OFF_COLOR
        marker.pose.position.x, marker.pose.position.y, marker.pose.position.z = x, y, z
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = 2.0 * radius
        marker.scale.z = ROBOT_HEIGHT_M
        markers.append(marker)
    ends = _points(np.array([positions[row] for link in links for row in link]).reshape(-1, positions.shape[1]))
    lines = Marker(header=header, ns="links", type=Marker.LINE_LIST, color=LINK_COLOR, points=ends)
    lines.pose.orientation.w = 1.0
    lines.scale.x = LINK_WIDTH_M
    return MarkerArray(markers=[*markers, lines])


def _outline(header: Header, name: str, number: int, corners: FloatArray, color: ColorRGBA) -> Marker:
    closed = np.vstack([corners, corners[:1]])
    marker = Marker(header=header, ns=name, id=number, type=Marker.LINE_STRIP, color=color, points=_points(closed))
    marker.pose.orientation.w = 1.0
    marker.scale.x = LINE_WIDTH_M
    return marker


def _points(positions: FloatArray) -> list[Point]:
    return [Point(x=place[0], y=place[1], z=0.0 if len(place) < 3 else place[2]) for place in positions.tolist()]


def _pose(position: Sequence[float] | FloatArray, yaw: float) -> Pose:
    z, w = quaternion_of(yaw)
    x, y, height = (*map(float, position), 0.0)[:3]
    return Pose(position=Point(x=x, y=y, z=height), orientation=Quaternion(z=z, w=w))


def _header(seconds: float) -> Header:
    return Header(stamp=time_message(seconds), frame_id=MAP_FRAME)
