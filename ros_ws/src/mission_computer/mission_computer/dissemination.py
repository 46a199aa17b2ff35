"""When to say it again: a plan is repeated until every reachable robot has acknowledged it."""

from __future__ import annotations

from collections.abc import Iterable

from mission_computer.config import MissionConfig
from swarm_msgs_py.types import NodeId


class Dissemination:
    """Keeps who has acknowledged the plan in force, and when it is to be flooded.

    Parameters
    ----------
    config : MissionConfig
        Pauses between floods. They grow, so that a robot that cannot answer does not fill the channel.
    """

    def __init__(self, config: MissionConfig) -> None:
        self._config = config
        self._epoch = 0
        self._informed: set[NodeId] = set()
        self._floods = 0
        self._due = 0.0
        self._flooded_at = -float("inf")
        self._pause = config.repeat_first_s

    @property
    def informed(self) -> tuple[NodeId, ...]:
        """Robots that hold the plan, ascending."""
        return tuple(sorted(self._informed))

    def restart(self, epoch: int, time: float) -> None:
        """Begin with a new plan, due at once."""
        self._epoch = epoch
        self._informed.clear()
        self._floods = 0
        self._due = time
        self._pause = self._config.repeat_first_s

    def acknowledge(self, robot: NodeId, epoch: int) -> None:
        """Note that `robot` holds the plan of `epoch`; a robot that lost it (a restart) counts as uninformed again."""
        if epoch == self._epoch:
            self._informed.add(robot)
        else:
            self._informed.discard(robot)

    def is_due(self, time: float, reachable: Iterable[NodeId]) -> bool:
        """Return whether to flood now; if so, the next flood is put off by the next pause.

        The first flood of a plan is due even if no robot is known yet.
        """
        if time < self._due or (self._floods and self._informed.issuperset(reachable)):
            return False
        self._floods += 1
        self._flooded_at = time
        self._due = time + self._pause
        self._pause = min(self._pause * self._config.repeat_growth, self._config.repeat_longest_s)
        return True

    def is_on_its_way(self, time: float) -> bool:
        """Return whether the plan was flooded so lately that who asks for it will have it anyway.

        In a crowd all neighbors see the number of a new plan at once, and would ask for it at once.
        """
        return time - self._flooded_at < self._config.repeat_first_s
