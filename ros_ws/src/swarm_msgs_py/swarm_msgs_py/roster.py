"""Who there is to place: how many robots of which type, and how large they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import RobotType
from swarm_msgs_py.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True, kw_only=True)
class TypeGroup(Config):
    """All robots of one type."""

    type: int = setting(help="type number, as goals refer to it", minimum=1, maximum=255)
    count: int = setting(help="number of robots of this type", minimum=1, maximum=1000)
    coverage_radius_m: float = setting(help="radius of the smallest circle that covers a robot", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Roster(Config):
    """The robots that a shape is to be filled with."""

    groups: tuple[TypeGroup, ...] = setting(help="one entry per robot type")

    def __post_init__(self) -> None:
        """Check that there is at least one robot and that no type is named twice.

        Raises
        ------
        ConfigError
            Naming the type that appears twice.
        """
        Config.__post_init__(self)
        if not self.groups:
            raise ConfigError("roster has no robots; add at least one group")
        for number, times in sorted(Counter(group.type for group in self.groups).items()):
            if times > 1:
                raise ConfigError(f"roster lists robot type {number} {times} times; merge them into one group")

    @classmethod
    def of(cls, types: Iterable[RobotType]) -> Roster:
        """Return the roster of a swarm, from the type of each of its robots.

        Raises
        ------
        ConfigError
            If there are no robots, or two types share a number and differ in size.
        """
        counts = Counter((robot.type, robot.coverage_radius_m) for robot in types)
        return cls(
            groups=tuple(
                TypeGroup(type=number, count=count, coverage_radius_m=radius)
                for (number, radius), count in sorted(counts.items())
            )
        )

    @property
    def size(self) -> int:
        """Number of robots."""
        return sum(group.count for group in self.groups)

    def without(self, types: Iterable[int]) -> Roster:
        """Return the roster of those who are left when one robot of each type in `types` is gone.

        Types are repeated as often as robots are gone; those beyond what the roster has do not count.

        Raises
        ------
        ConfigError
            If nobody is left.
        """
        gone = Counter(types)
        counts = {group.type: group.count - gone[group.type] for group in self.groups}
        left = tuple(replace(group, count=counts[group.type]) for group in self.groups if counts[group.type] > 0)
        if not left:
            raise ConfigError("no robot is left")
        return Roster(groups=left)

    def interleaved_types(self) -> IntArray:
        """Return one type number per robot, every type spread as evenly as it can be over the sequence.

        Returns
        -------
        (n,) int array
            Robot k of the c robots of a type stands at the fraction (k + 1/2) / c of the sequence.
        """
        keyed = [
            ((k + 0.5) / group.count, order, group.type)
            for order, group in enumerate(self.groups)
            for k in range(group.count)
        ]
        return np.array([number for _, _, number in sorted(keyed)], dtype=np.int64)

    def radii_of(self, types: IntArray) -> FloatArray:
        """Return the coverage radius [m] of each type number in `types`."""
        radius = {group.type: group.coverage_radius_m for group in self.groups}
        return np.array([radius[int(number)] for number in types], dtype=np.float64)
