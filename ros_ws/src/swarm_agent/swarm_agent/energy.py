"""How much energy a robot has left, by a declared model: so much for each meter and each second."""

from __future__ import annotations

import math
from dataclasses import dataclass

from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.messages.control import VelocityCommand


@dataclass(frozen=True, slots=True, kw_only=True)
class EnergyConfig(Config):
    """The robot's store of energy, in shares of a full one; by default it does not run down.

    The store matters to the decision only (`agent.decision.weight`): an empty robot still drives.
    """

    initial: float = setting(
        1.0, "energy at the start; in a scenario robots.energies", unit="full stores", minimum=0.0, maximum=1.0
    )
    per_meter: float = setting(0.0, "spent on each meter driven", unit="full stores/m", minimum=0.0)
    per_second: float = setting(0.0, "spent in each second, also at rest", unit="full stores/s", minimum=0.0)


class EnergyStore:
    """Counts down what one robot spends.

    Parameters
    ----------
    config : EnergyConfig
    period_s : float
        Control period [s].
    """

    def __init__(self, config: EnergyConfig, period_s: float) -> None:
        self._config = config
        self._period = period_s
        self._left = config.initial

    @property
    def left(self) -> float:
        """Share of a full store, 0 to 1."""
        return self._left

    def spend(self, command: VelocityCommand) -> None:
        """Count one tick under this command; what is driven is what was commanded."""
        meters = math.hypot(command.forward, command.left) * self._period
        spent = self._config.per_meter * meters + self._config.per_second * self._period
        self._left = max(0.0, self._left - spent)
