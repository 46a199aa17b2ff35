"""Which strategy decides: the one for what the plan in force asks."""

from __future__ import annotations

from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.decision.strategy import Decision
from swarm_agent.forces.forming import ForceForming
from swarm_msgs_py.types import FloatArray


class ByTask:
    """Hands each tick to goal seeking or to the forces, as the plan says; so a plan can change the method on the way.

    Parameters
    ----------
    consensus : Consensus
        The robot's copy of the plan.
    goals : GoalSeeking
        Also for the time before there is a plan.
    forces : ForceForming
    """

    def __init__(self, consensus: Consensus, goals: GoalSeeking, forces: ForceForming) -> None:
        self._consensus = consensus
        self._goals = goals
        self._forces = forces

    def step(
        self, tick: int, position: FloatArray, sigma: float, takes_part: bool = True, is_blocked: bool = False
    ) -> Decision:
        """Return the decision for this tick; see `Strategy`."""
        plan = self._consensus.plan
        if plan is None or plan.task.has_goals:
            return self._goals.step(tick, position, takes_part, is_blocked)
        return self._forces.step(tick, position, sigma, plan, takes_part=takes_part)
