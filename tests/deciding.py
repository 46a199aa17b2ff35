"""A robot's decision without a body around it."""

from __future__ import annotations

from swarm_agent.decision.config import DecisionConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.goal_seeking import GoalSeeking
from swarm_agent.energy import EnergyConfig, EnergyStore
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import NodeId


def goal_seeking(robot: NodeId, config: DecisionConfig, period_s: float) -> tuple[Consensus, GoalSeeking]:
    """Return the decision of a robot of type 1 that hears nobody, and its copy of the common knowledge."""
    mesh = MeshNetwork(robot, NetworkConfig(), period_s)
    mesh.receive(0, ())
    consensus = Consensus(robot, 1, config, period_s)
    strategy = GoalSeeking(
        robot,
        THESIS_TYPES[0],
        config=config,
        planning=PlanningConfig(),
        mesh=mesh,
        consensus=consensus,
        energy=EnergyStore(EnergyConfig(), period_s),
        obstacles=(),
        period_s=period_s,
    )
    return consensus, strategy
