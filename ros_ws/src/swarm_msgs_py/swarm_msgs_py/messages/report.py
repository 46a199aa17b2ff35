"""What actors say of themselves to viewers; nothing in the swarm depends on it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from swarm_msgs_py.messages.camera_report import CameraReport
from swarm_msgs_py.messages.radio import RadioCounters
from swarm_msgs_py.types import FloatArray, NodeId


class Mode(IntEnum):
    """What a robot is doing."""

    WAITING = 0  # no position yet
    SEARCHING = 1  # no plan heard: drives to the rally point, where the mission computer's radio is
    UNASSIGNED = 2  # holds a plan, but no goal: the rows are not complete, or every goal is better taken by another
    TRAVELING = 3  # on its way to its goal, or driven by forces
    PARKED = 4  # at its goal; in a formation without goals, at rest inside the shape
    BLOCKED = 5  # on its way, but hardly getting on: asks its neighbors to make way
    RETURN_HOME = 6  # lost for too long: drives to the middle of the shape, where beacons are
    BLIND = 7  # depends on the overhead camera, which has not seen it for too long: stands still


class Positioning(IntEnum):
    """How well a robot knows where it is (spec section 6)."""

    LOCALIZED = 0
    LOST = 1  # goes on with what it does, by dead reckoning
    RETURN_HOME = 2  # lost for too long


@dataclass(frozen=True, slots=True)
class LocalizationReport:
    """How a robot knows where it is, for viewers.

    Attributes
    ----------
    positioning : Positioning
    lost_by_beacons, lost_by_sigma : bool
        What the two definitions of "lost" said at the last review, whichever of them acts.
    shared : float
        Share of the position's variance that is common with the neighbors' errors, 0 to 1.
    accepted, rejected : int
        Fixes and ranges used, and thrown out as outliers, since the start.
    disagreements : int
        Times that a beacon was a direct neighbor by its hellos, but not by the route table (spec section 5.4).
    """

    positioning: Positioning
    lost_by_beacons: bool
    lost_by_sigma: bool
    shared: float
    accepted: int
    rejected: int
    disagreements: int


@dataclass(frozen=True, slots=True, eq=False)
class AgentReport:
    """State of one robot after a tick, for viewers, recorders and metrics.

    Attributes
    ----------
    position, velocity : (2,) array
        Own estimate, world frame [m], [m/s].
    covariance : (2, 2) array
        Of the position estimate [m^2].
    yaw : float
        Heading [rad].
    mode : Mode
    localization : LocalizationReport
    epoch : int
        Plan held, 0 for none.
    goal : int
        Goal id, -1 for none.
    path : (k, 2) array
        Way-points still to come, the goal last [m]; k may be 0.
    neighbors : tuple of NodeId
        Radios heard directly.
    beacons : int
        How many of them carry a position sensor.
    routes : int
        Destinations that can be reached over the mesh.
    rows : int
        Cost rows held for the plan.
    counters : RadioCounters
    goals_crc : int
        Checksum of the goals in the plan held (`swarm_msgs_py.plan_goals.goals_crc`), 0 for none. Robots that found
        their goals by themselves found the same ones if it is the same.
    """

    position: FloatArray
    velocity: FloatArray
    covariance: FloatArray
    yaw: float
    mode: Mode
    localization: LocalizationReport
    epoch: int
    goal: int
    path: FloatArray
    neighbors: tuple[NodeId, ...]
    beacons: int
    routes: int
    rows: int
    counters: RadioCounters
    goals_crc: int = 0


@dataclass(frozen=True, slots=True)
class MissionReport:
    """State of the mission computer after a tick.

    Attributes
    ----------
    epoch : int
        Plan that is in force, 0 for none.
    informed : tuple of NodeId
        Robots that have acknowledged it.
    reachable : tuple of NodeId
        Robots to which the mesh has a route.
    parked : tuple of NodeId
        Robots that report to be at their goal.
    notice : str
        One line for the operator, empty when there is nothing to say (e.g. why a shape was refused).
    counters : RadioCounters
    stage : int
        Which stage of the schedule is in force, 0 for the first shape.
    stages_left : int
        Stages of the schedule that are still to come, or would be.
    is_broken_off : bool
        Whether the schedule goes no further, because its next stage was refused.
    camera : CameraReport or None
        What the image of this tick told; None if there was none.
    """

    epoch: int
    informed: tuple[NodeId, ...]
    reachable: tuple[NodeId, ...]
    parked: tuple[NodeId, ...]
    notice: str
    counters: RadioCounters
    stage: int = 0
    stages_left: int = 0
    is_broken_off: bool = False
    camera: CameraReport | None = None
