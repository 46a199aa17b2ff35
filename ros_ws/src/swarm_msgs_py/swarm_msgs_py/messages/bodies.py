"""Application records that travel in packets: the plan, cost rows, reports, repair requests."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.messages.sensing import PoseFix
from swarm_msgs_py.partition.config import Method
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray, IntArray, NodeId


class Task(Enum):
    """What a plan asks of the robots."""

    GOALS = "goals"  # to share out the goals that the plan names
    PARTITION = "partition"  # to find the goals from the shape, each robot by itself, and to share them out
    FORCES = "forces"  # to let the forces of shape, neighbors and obstacles drive them: no goals, own force law
    FORCES_LITERAL = "forces-literal"  # likewise under the thesis' force law

    @property
    def has_goals(self) -> bool:
        """Whether robots that do this have goals."""
        return self in {Task.GOALS, Task.PARTITION}


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """How the shape of a plan comes about: known in advance, so that one plan tells all of it.

    Attributes
    ----------
    begins : int
        Tick in which the shape begins to move.
    ticks : int
        How long it moves, at least 1.
    start : (k, 2) array
        Contour at the beginning, counter-clockwise [m]; the plan has the one at the end.
    rotation_rad : float
        By how much the shape turns on its way, counter-clockwise; it may be more than a full turn [rad].
    track : (m, n, 2) array
        Goals at m = `knots` equal intervals from beginning to end, both included [m]. As decoded, a plan for
        `Task.PARTITION` has only the first of them (m = 1): `swarm_msgs_py.plan_goals.completed` finds the others. No
        goals (n = 0, whatever m): the robots are driven by forces.
    knots : int
        How many intervals' ends there are, at least 2.
    """

    begins: int
    ticks: int
    start: FloatArray
    rotation_rad: float
    track: FloatArray
    knots: int

    @property
    def ends(self) -> int:
        """Tick from which on the shape is at rest."""
        return self.begins + self.ticks


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """What the swarm is to do: the mission computer's numbered broadcast.

    Attributes
    ----------
    epoch : int
        Number of the plan, 1, 2, ...; a higher epoch replaces a lower one.
    contour : (k, 2) array
        Desired shape, counter-clockwise [m].
    obstacles : tuple of (m, 2) array
        Polygons that robots and radio links cannot cross [m].
    goals : (n, 2) array
        Goal positions [m]; the row number is the goal's id. On the air only if the task is `Task.GOALS`; in a plan for
        `Task.PARTITION` they are there once the plan is completed (`swarm_msgs_py.plan_goals.completed`).
    goal_types : (n,) int array
        Type of robot that each goal is made for.
    bodies : int
        How many of the obstacles, the last ones, are bodies of lost robots. They are about there; a wall stands where
        the map has it.
    task : Task
        What the robots are to do.
    roster : Roster or None
        For whom the shape is; None in a plan that names the goals, which says it by them.
    method : Method or None
        Of the partition, for `Task.PARTITION`.
    goals_crc : int
        For `Task.PARTITION`, the checksum of the goals that the mission computer found.
    motion : Motion or None
        How the shape comes about; None: it is there at once. Contour and goals of the plan are those at the end of the
        motion, so whoever knows nothing of motions sees a plan for the end of it.
    follows : int
        Epoch of the plan whose goals, by id, are where the goals of this one begin; 0: of none.
    heading : float or None
        Direction that all robots are to face, in [-pi, pi] [rad]; None: that is left to them.
    """

    epoch: int
    contour: FloatArray
    obstacles: tuple[FloatArray, ...]
    goals: FloatArray
    goal_types: IntArray
    bodies: int = 0
    task: Task = Task.GOALS
    roster: Roster | None = None
    method: Method | None = None
    goals_crc: int = 0
    motion: Motion | None = None
    follows: int = 0
    heading: float | None = None

    @property
    def robot_count(self) -> int:
        """How many robots the plan is for."""
        return self.roster.size if self.roster is not None else len(self.goals)

    @property
    def walls(self) -> tuple[FloatArray, ...]:
        """The obstacles of the map."""
        return self.obstacles[: len(self.obstacles) - self.bodies]

    @property
    def body_outlines(self) -> tuple[FloatArray, ...]:
        """The obstacles that are bodies."""
        return self.obstacles[len(self.obstacles) - self.bodies :]


EPOCH_LEAP_MAX = 2**20
"""By how much one plan may be numbered beyond the last; more is noise, and would shut out all real plans after it."""


def is_newer_epoch(epoch: int, held: int) -> bool:
    """Return whether a plan of number `epoch` replaces the one `held`; an absurdly high number is noise and does not.

    All who number, adopt or ask for plans use this rule, so that one damaged number cannot wedge the swarm.
    """
    return held < epoch <= held + EPOCH_LEAP_MAX


WEIGHT_ONE, WEIGHT_MAX = 256, 0xFFFF
"""Weight of an ordinary robot, and the largest; fixed point, so that weighted costs are whole numbers everywhere."""


class Objective(Enum):
    """What an assignment of goals is to make as small as it can be."""

    TOTAL = "total"  # sum of all weighted paths
    BOTTLENECK = "bottleneck"  # longest weighted path of any robot; among those assignments, the sum


@dataclass(frozen=True, slots=True, eq=False)
class CostRow:
    """What each goal of its type would cost one robot.

    Attributes
    ----------
    epoch : int
        Plan that the costs refer to.
    robot : NodeId
        Whose row it is.
    robot_type : int
        Type of the robot; the row covers the plan's goals of this type in ascending goal id.
    version : int
        Rows of one robot and epoch are numbered 1, 2, ...; the highest counts. A withdrawn robot's row is empty.
    costs : (m,) int array
        Length of the shortest free path to each goal, in steps that the swarm has agreed on (by default centimeters);
        `UNREACHABLE` where there is none.
    weight : int
        How much a meter of this robot counts, in units of 1 / `WEIGHT_ONE`; 1 to `WEIGHT_MAX`.
    objective : Objective
        What the robot would have the swarm minimize. The rows together decide: what most of them say.
    """

    epoch: int
    robot: NodeId
    robot_type: int
    version: int
    costs: IntArray
    weight: int = WEIGHT_ONE
    objective: Objective = Objective.TOTAL


VERSION_LEAP_MAX = 1024
"""By how much one version may be numbered beyond the last; more is noise, and would shut out the robot's real rows."""

UNREACHABLE = 0xFFFF
"""Cost that stands for: there is no path."""


@dataclass(frozen=True, slots=True)
class RowRequest:
    """Asks one neighbour for the plan and for rows that it holds and the sender lacks.

    Attributes
    ----------
    epoch : int
        Epoch that the sender holds (0: none; then only the plan is asked for).
    held : tuple of (NodeId, int)
        Robot and version of every row that the sender holds.
    """

    epoch: int
    held: tuple[tuple[NodeId, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class RowBundle:
    """Answer to a `RowRequest`: the rows that the asker lacked."""

    rows: tuple[CostRow, ...]


@dataclass(frozen=True, slots=True)
class Report:
    """A robot's report to the mission computer, sent as a routed packet.

    Attributes
    ----------
    robot : NodeId
    robot_type : int
    epoch : int
        Newest plan held; this is the acknowledgement that ends the repetition of a plan.
    goal : int
        Goal id taken, -1 for none.
    position : (x, y)
        Own estimate [m].
    mode : int
        Value of the robot's mode.
    sigma : float
        Standard deviation of that position, root mean square of both axes [m].
    """

    robot: NodeId
    robot_type: int
    epoch: int
    goal: int
    position: tuple[float, float]
    mode: int
    sigma: float


@dataclass(frozen=True, slots=True, eq=False)
class CameraFixes:
    """What one image of the overhead camera tells of all robots in it.

    Attributes
    ----------
    tick : int
        In which the image was taken; who hears of it later must bring the fixes forward.
    fixes : tuple of PoseFix
        Robots that were found, ascending.
    """

    tick: int
    fixes: tuple[PoseFix, ...]


Body = Plan | CostRow | RowRequest | RowBundle | Report | CameraFixes
