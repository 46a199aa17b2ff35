"""All settings of one robot's software."""

from __future__ import annotations

from dataclasses import dataclass

from swarm_agent.control.config import ControlConfig
from swarm_agent.decision.config import DecisionConfig
from swarm_agent.energy import EnergyConfig
from swarm_agent.forces.config import ForceConfig
from swarm_agent.localization.config import LpsConfig
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.config import Config, section
from swarm_msgs_py.networking.config import NetworkConfig


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentConfig(Config):
    """Settings of one robot; the same for the whole swarm but for `decision.weight.priority` and `energy.initial`."""

    lps: LpsConfig = section(LpsConfig, "local positioning")
    network: NetworkConfig = section(NetworkConfig, "neighbor discovery, routing and delivery")
    planning: PlanningConfig = section(PlanningConfig, "free space and paths")
    decision: DecisionConfig = section(DecisionConfig, "who takes which goal")
    forces: ForceConfig = section(ForceConfig, "artificial forces, where the plan asks for them")
    control: ControlConfig = section(ControlConfig, "path following and collision avoidance")
    energy: EnergyConfig = section(EnergyConfig, "what the robot has left to drive with")
