"""What varies between formation methods on the robot: where to, or how it should move, given what it knows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.report import Mode
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, NodeId


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """Outcome of one decision tick.

    Attributes
    ----------
    goal : int
        Goal id in the plan, -1 for none.
    destination : (2,) array or None
        Where to drive [m]; None to stand still, or to move as `velocity` says.
    mode : Mode
        What the robot is doing, as far as the decision knows (it may turn out to be parked or blocked).
    obstacles : tuple of (m, 2) array
        Map to plan the path on [m].
    velocity : (2,) array or None
        How to move, world frame [m/s], where no place is wanted but a motion. Collision avoidance has the last word.
    drift : (2,) array or None
        How the destination itself moves until the next tick, world frame [m/s]; None: it is at rest.
    """

    goal: int
    destination: FloatArray | None
    mode: Mode
    obstacles: tuple[FloatArray, ...]
    velocity: FloatArray | None = None
    drift: FloatArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """What a decision method works with; a class that an installed package adds is made with it.

    Attributes
    ----------
    robot : NodeId
        Who decides.
    robot_type : RobotType
        Its mechanics; goals are made for a type.
    period_s : float
        Control period [s].
    config : DecisionConfig
    planning : PlanningConfig
        How `swarm_agent.planning.path_planner.planner_for` plans.
    mesh : Network
        The robot's radio network: neighbors with what their hellos say, routes, sending and flooding.
    consensus : Consensus
        The robot's copy of the plan in force (`plan`, None before one was heard), and of the cost rows.
    obstacles : tuple of (m, 2) array
        Map known before a plan brings one [m].
    """

    robot: NodeId
    robot_type: RobotType
    period_s: float
    config: DecisionConfig
    planning: PlanningConfig
    mesh: Network
    consensus: Consensus
    obstacles: tuple[FloatArray, ...]


class Strategy(Protocol):
    """Decides where the robot should be or how it should move, once per tick."""

    def step(
        self, tick: int, position: FloatArray, sigma: float, takes_part: bool = True, is_blocked: bool = False
    ) -> Decision:
        """Return the decision for this tick.

        Parameters
        ----------
        tick : int
        position : (2,) array
            The robot's own estimate [m].
        sigma : float
            Its standard deviation, per axis [m].
        takes_part : bool
            Whether the robot is there for the formation; if not, it withdraws until it is again.
        is_blocked : bool
            Whether the robot is hardly getting on, for what is in its way.
        """
        ...
