"""Settings of the partition: which method, how much room to leave, and its tuning."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting


class Method(Enum):
    """Ways of turning a shape into goals."""

    BUBBLE_PACKING = "bubble-packing"


class BubbleLaw(Enum):
    """Force laws between bubbles."""

    SCALED = "scaled"
    """Shimada and Gossard's cubic, its range scaled to the area per robot."""
    THESIS = "thesis"
    """Thesis eq. (3.95) with its fixed range; suits 50 robots on 270 to 320 m^2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaps(Config):
    """Least free distances around a goal's circle."""

    robot_m: float = setting(0.3, "to the circle of another goal, room for the avoidance", unit="m", minimum=0.01)
    contour_m: float = setting(0.15, "to the contour, room for the parking error", unit="m", minimum=0.01)
    obstacle_m: float = setting(0.2, "to obstacles, beyond the margin of the path planner", unit="m", minimum=0.01)


@dataclass(frozen=True, slots=True, kw_only=True)
class BubbleConfig(Config):
    """Tuning of bubble packing (spec section 9.2).

    Defaults have the most regular meshes of those tried on the four formation shapes in five orientations. A long range
    at first, shortened while the bubbles settle, heals the lattice defects that the spread from the center leaves, as
    annealing does.
    """

    law: BubbleLaw = setting(BubbleLaw.SCALED, "force law between bubbles")
    beta: float = setting(1.1, "range l0 of the force, in hexagonal spacings", minimum=1.0, maximum=1.5)
    softness: float = setting(0.6, "the packing begins with a range longer by this share", minimum=0.0, maximum=2.0)
    softening: float = setting(0.5, "share of the iterations until the range is l0", minimum=0.0, maximum=1.0)
    eta: float = setting(0.0, "share of radius in the range: 0 even centers, 0.25 even gaps", minimum=0.0, maximum=1.0)
    kappa: float = setting(0.2, "gain of the shape force", minimum=0.0, maximum=2.0)
    step: float = setting(0.05, "step per unit of force, in ranges l0", above=0.0, maximum=0.2)
    step_max: float = setting(0.1, "longest step, in ranges l0", above=0.0, maximum=0.5)
    iterations_max: int = setting(1200, "iterations at most", minimum=1, maximum=100_000)
    tolerance_m: float = setting(1e-4, "converged when no bubble moves farther in a step", unit="m", above=0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PartitionConfig(Config):
    """How a shape becomes goals."""

    method: Method = setting(Method.BUBBLE_PACKING, "partition method")
    gaps: Gaps = section(Gaps, "least free distances")
    bubbles: BubbleConfig = section(BubbleConfig, "tuning of bubble packing")
