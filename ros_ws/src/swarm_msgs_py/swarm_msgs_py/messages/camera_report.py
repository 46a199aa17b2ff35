"""What the mission computer reads out of one image."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.markers import MarkerColor
from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.types import NodeId


class CameraStatus(Enum):
    """Whether an image could be read at all."""

    OK = "ok"
    UNCALIBRATED = "uncalibrated"
    """The floor marks were never seen well enough to know where the camera is."""
    DARK = "dark"
    """Nearly all pixels show nothing."""


class Refusal(Enum):
    """Why a robot has no fix in an image, the first reason that applies."""

    NOT_SEEN = "not seen"
    """Nothing that could be on its cover: it is missing, out of view, or in a dark part of the image."""
    CUT_OFF = "cut off"
    """A disc ends at the border of the image or of a dark part."""
    DEFORMED = "deformed"
    """Blobs of its color are no discs of its sizes on black: covered, merged with something, or something else."""
    ONE_DISC = "one disc"
    """Only one of the two discs is there."""
    MISMATCH = "mismatch"
    """Both sizes of discs are there, but not at the distance that they have on the cover."""
    AMBIGUOUS = "ambiguous"
    """More than one pair of discs could be the robot, and its track does not tell which."""
    ELSEWHERE = "not where it was"
    """Its two discs show where it cannot have driven: a look-alike, unless they stay."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotFix(PoseFix):
    """Where a robot was when the image was taken, and how well that shows.

    Attributes
    ----------
    quality : float
        1: the discs are exactly as on the cover; 0: at a tolerance.
    """

    quality: float


@dataclass(frozen=True, slots=True)
class Rejection:
    """A robot without a fix."""

    robot: NodeId
    color: MarkerColor
    reason: Refusal


@dataclass(frozen=True, slots=True)
class Stray:
    """A colored blob that is on no robot, as far as one can tell.

    Attributes
    ----------
    color : MarkerColor
    position : (x, y)
        As if it were at the height of the covers [m].
    """

    color: MarkerColor
    position: tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class CameraReport:
    """All that one image told.

    Attributes
    ----------
    time : float
        When the image was taken [s].
    status : CameraStatus
    fixes : tuple of RobotFix
        Ascending robots.
    rejections : tuple of Rejection
        The other robots, ascending; empty unless the status is OK.
    strays : tuple of Stray
    dead_share : float
        Share of the pixels that show nothing.
    note : str
        What there is to say of the image, in words: why it could not be read, or that the camera has moved.
    """

    time: float
    status: CameraStatus
    fixes: tuple[RobotFix, ...]
    rejections: tuple[Rejection, ...]
    strays: tuple[Stray, ...]
    dead_share: float
    note: str = ""
