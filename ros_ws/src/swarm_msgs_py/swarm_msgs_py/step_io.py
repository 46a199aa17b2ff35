"""The step contracts: what an actor is given each tick, and what it gives back.

``inputs.time == inputs.tick * control period``. Equal inputs, in the same order, give equal outputs.
"""

from __future__ import annotations

from dataclasses import dataclass

from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.camera import CameraImage, CameraInfo
from swarm_msgs_py.messages.control import VelocityCommand
from swarm_msgs_py.messages.report import AgentReport, MissionReport
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class AgentInputs:
    """All that one robot learns in one tick: its own sensors and the frames its radio heard.

    Attributes
    ----------
    tick : int
    time : float
        Simulated time [s].
    imu : ImuSample
    fix : PositionFix or None
        None for a robot without position sensor, or when the sensor gives nothing.
    ranges : RangeScan
        Empty in ticks in which no ranging is due.
    proximity : (n, 2) array
        Nearest surface point of every robot and obstacle within sensing range, body frame, origin at the robot's
        centre [m]. Robots and walls look alike.
    inbox : tuple of bytes
        Frames heard since the last tick, in order of reception.
    """

    tick: int
    time: float
    imu: ImuSample
    fix: PositionFix | None
    ranges: RangeScan
    proximity: FloatArray
    inbox: tuple[bytes, ...]


@dataclass(frozen=True, slots=True, eq=False)
class AgentOutputs:
    """All that one robot does in one tick."""

    tick: int
    command: VelocityCommand
    outbox: tuple[bytes, ...]
    report: AgentReport


@dataclass(frozen=True, slots=True, eq=False)
class MissionInputs:
    """All that the mission computer learns in one tick.

    Attributes
    ----------
    tick : int
    time : float
        Simulated time [s].
    inbox : tuple of bytes
        Frames heard by its radio.
    shape : (k, 2) array or None
        New contour ordered by the operator [m]; None when nothing new was ordered.
    image : CameraImage or None
        Taken now by the overhead camera; None where there is none, or it gives nothing.
    camera : CameraInfo or None
        What the camera's maker says of it; None as long as that is not known.
    """

    tick: int
    time: float
    inbox: tuple[bytes, ...]
    shape: FloatArray | None = None
    image: CameraImage | None = None
    camera: CameraInfo | None = None


@dataclass(frozen=True, slots=True, eq=False)
class MissionOutputs:
    """All that the mission computer does in one tick.

    Attributes
    ----------
    tick : int
    outbox : tuple of bytes
        Frames to transmit.
    plan : Plan or None
        The plan, in the tick in which it changed.
    report : MissionReport
    """

    tick: int
    outbox: tuple[bytes, ...]
    plan: Plan | None
    report: MissionReport
