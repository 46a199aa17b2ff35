"""Exchange of goals between two robots of one type, of which the one stands in the way of the other.

Robots that follow shortest paths of a fresh assignment hardly ever meet head-on, since to exchange their goals would be
shorter for both. It happens all the same: rows were made where the robots are not any more, a robot returns from being
lost, or a parked robot closes a passage to a goal behind it. Avoidance cannot let them pass where there is no room.

No handshake is needed. The blocked robot offers a fresh row, in which the goals behind the robot in its way cost more.
That row reaches everybody as every row does, and the one assignment that all compute from the rows exchanges the goals
(or finds something better). However many frames are lost, no two robots end with one goal.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from swarm_agent.decision.config import SwapConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.path_costs import PathCosts
from swarm_msgs_py.messages.bodies import UNREACHABLE, Plan
from swarm_msgs_py.networking.network import Network
from swarm_msgs_py.types import FloatArray, IntArray, NodeId

DOUBLINGS_MAX = 4
"""Offers without end cost radio time, and a worth without end would send the swap anywhere."""


class SwapOffers:
    """Says when one robot offers an exchange, and what that makes dearer for it.

    Parameters
    ----------
    robot : NodeId
        Who offers.
    config : SwapConfig
    paths : PathCosts
        Of its type.
    mesh : Network
        Tells who is near.
    consensus : Consensus
        The robot's copy of plan and rows.
    period_s : float
        Control period [s].
    """

    def __init__(  # noqa: PLR0913, PLR0917 - collaborators, each named at the one place of construction
        self,
        robot: NodeId,
        config: SwapConfig,
        paths: PathCosts,
        mesh: Network,
        consensus: Consensus,
        period_s: float,
    ) -> None:
        self._robot = robot
        self._config = config
        self._paths = paths
        self._mesh = mesh
        self._consensus = consensus
        self._period = period_s
        self._since = 0  # epoch with which the rows began
        self._blocked = 0.0  # seconds, of late
        self._tries = 0  # for this plan

    def step(
        self,
        tick: int,
        plan: Plan,
        position: FloatArray,
        taken: Mapping[NodeId, int],
        *,
        is_blocked: bool,
    ) -> IntArray | None:
        """Return by how much each goal of the type is dearer for the robot [steps], None if no exchange is due.

        Parameters
        ----------
        tick : int
        plan : Plan
            In force.
        position : (2,) array
            Own estimate [m].
        taken : mapping of NodeId to int
            What the rows say of everybody: robot to position among the goals of its type.
        is_blocked : bool
            Whether it is hardly getting on.
        """
        since = self._consensus.book.since
        if since != self._since:
            self._since, self._blocked, self._tries = since, 0.0, 0
        self._blocked = max(0.0, self._blocked + (self._period if is_blocked else -self._period))
        own, after, growth = taken.get(self._robot), self._config.after_s, 2 ** min(self._tries, DOUBLINGS_MAX)
        if after is None or own is None or not is_blocked or self._blocked < after * growth:
            return None
        mine = self._paths.of(tick, plan, position)
        in_the_way = self._in_the_way(tick, plan, position, taken, mine)
        if in_the_way:
            self._blocked = 0.0
            self._tries += 1
        worth = self._paths.steps(self._config.worth_m) * growth
        for neighbor, theirs, beyond in in_the_way:
            if self._is_worth_it((own, taken[neighbor]), (mine, theirs), neighbor, worth):
                return np.where(beyond, worth, 0)
        return None

    def _in_the_way(
        self, tick: int, plan: Plan, position: FloatArray, taken: Mapping[NodeId, int], mine: IntArray
    ) -> list[tuple[NodeId, IntArray, NDArray[np.bool_]]]:
        """Return the robots between this one and its goal, nearest first: their costs [steps], and goals behind them.

        Only those count with which goals can be exchanged. The goal of the other one is not behind it: it will leave.
        """
        found = []
        for apart, neighbor, theirs in self._near(tick, plan, position, taken):
            beyond = apart + theirs <= mine + self._paths.steps(self._config.detour_max_m)
            beyond[taken[neighbor]] = False
            if beyond[taken[self._robot]]:
                found.append((neighbor, theirs, beyond))
        return found

    def _near(
        self, tick: int, plan: Plan, position: FloatArray, taken: Mapping[NodeId, int]
    ) -> list[tuple[int, NodeId, IntArray]]:
        """Return neighbors of the own type that have goals, nearest first: how far off, and what they pay [steps]."""
        near = []
        for neighbor, presence in self._mesh.neighbors.items():
            apart = float(np.hypot(*(presence.position - position)))
            is_alike = presence.robot_type == self._paths.robot_type and presence.epoch == plan.epoch
            if is_alike and neighbor in taken and apart <= self._config.distance_m:
                near.append((self._paths.steps(apart), neighbor, self._paths.of(tick, plan, presence.position)))
        return sorted(near, key=lambda entry: entry[:2])

    def _is_worth_it(
        self, goals: tuple[int, int], costs: tuple[IntArray, IntArray], neighbor: NodeId, worth: int
    ) -> bool:
        """Return whether an exchange costs no more than it is worth, by weight as in the assignment."""
        (own, its), (mine, theirs) = goals, costs
        before, after = np.array([mine[own], theirs[its]]), np.array([mine[its], theirs[own]])
        if (before == UNREACHABLE).any() or (after == UNREACHABLE).any():
            return False
        weights = np.array([self._consensus.book.weight_of(robot) for robot in (self._robot, neighbor)])
        return bool(weights @ (after - before) <= weights[0] * worth)
