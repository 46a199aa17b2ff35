"""Settings of the partition: which method, how much room to leave, and its tuning."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from swarm_msgs_py.config import Config, section, setting


class Method(Enum):
    """Ways of turning a shape into goals."""

    BUBBLE_PACKING = "bubble-packing"
    """Circles that push each other apart (thesis 3.2.2.1)."""
    FRACTALS = "fractals"
    """Circles at random points of what is free, largest first (thesis 3.2.2.2)."""
    VORONOI = "voronoi"
    """Centroidal Voronoi tessellation, which every robot can compute alone."""


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

    Defaults have regular meshes on the four formation shapes, however they are turned. A long range at first, shortened
    while the bubbles settle, heals the lattice defects that the spread from the center leaves, as annealing does.
    """

    law: BubbleLaw = setting(BubbleLaw.SCALED, "force law between bubbles")
    beta: float = setting(1.1, "range l0 of the force, in hexagonal spacings", minimum=1.0, maximum=1.5)
    softness: float = setting(0.6, "the packing begins with a range longer by this share", minimum=0.0, maximum=2.0)
    softening: float = setting(0.5, "share of the annealing until the range is l0", above=0.0, maximum=1.0)
    starts: int = setting(3, "placements that are annealed; the most regular one goes on", minimum=1, maximum=1000)
    annealing_iterations: int = setting(400, "iterations of each annealing", minimum=1, maximum=100_000)
    rim_stretch: float = setting(
        0.6, "from the second start on, ranges beside the contour are longer by this share", minimum=0.0, maximum=1.0
    )
    healings: int = setting(12, "moves of a crowded bubble into a hole that are tried", minimum=0, maximum=1000)
    healing_iterations: int = setting(120, "iterations after each of them", minimum=1, maximum=100_000)
    eta: float = setting(0.0, "share of radius in the range: 0 even centers, 0.25 even gaps", minimum=0.0, maximum=1.0)
    kappa: float = setting(0.2, "gain of the shape force", minimum=0.0, maximum=2.0)
    step: float = setting(0.05, "step per unit of force, in ranges l0", above=0.0, maximum=0.2)
    step_max: float = setting(0.1, "longest step, in ranges l0", above=0.0, maximum=0.5)
    iterations_max: int = setting(800, "iterations at most from there to rest", minimum=1, maximum=100_000)
    tolerance_m: float = setting(1e-4, "converged when no bubble moves farther in a step", unit="m", above=0.0)


class CircleSizes(Enum):
    """What the circles of randomized fractals are as large as."""

    COVERAGE = "coverage"
    """The robots' coverage circles, as in the formation problem."""
    HURWITZ = "hurwitz"
    """Circles that would fill the shape if they went on for ever (thesis (2.1)-(2.3)), the largest for large robots."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FractalConfig(Config):
    """Tuning of randomized fractals (spec section 10)."""

    seed: int | None = setting(
        None, "seed of the draws: equal seeds give equal goals; null: that of the run", minimum=0, maximum=2**32 - 1
    )
    clearance_m: float = setting(
        0.7, "free distance between circles, half of it to the contour, when room allows", unit="m", minimum=0.0
    )
    sizes: CircleSizes = setting(CircleSizes.COVERAGE, "sizes of the circles")
    exponent: float = setting(1.2, "c of the Hurwitz rule: how fast its circles become small", above=1.0, maximum=2.0)
    shift: float = setting(2.0, "N of the Hurwitz rule: makes its first circle smaller", above=0.0, maximum=1000.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class VoronoiConfig(Config):
    """Tuning of the centroidal Voronoi partition.

    Defaults were chosen on the four formation shapes: a lighter rim saves cells along the contour, a share for the
    triangles trades the cells' equal areas, of which there is enough, for equal distances.
    """

    starts: int = setting(9, "hexagonal lattices to begin with", minimum=1, maximum=1000)
    start_steps: int = setting(20, "steps for each of them", minimum=1, maximum=1000)
    finalists: int = setting(
        3, "most regular ones that are settled to the end, beside the packing", minimum=1, maximum=1000
    )
    steps_max: int = setting(30, "steps at most in the end", minimum=1, maximum=10_000)
    tolerance_m: float = setting(1e-3, "settled when no goal is to move farther in a step", unit="m", minimum=1e-5)
    rim_width: float = setting(0.7, "width of the lighter rim at the start, in spacings", minimum=0.0, maximum=2.0)
    core_density: float = setting(0.6, "density that the inside has more than the rim", minimum=0.0, maximum=10.0)
    radius_share: float = setting(
        0.35, "weight of a cell in spacings times radius: 0 equal cells, 1 equal free gaps", minimum=0.0, maximum=1.0
    )
    triangle_gain: float = setting(
        0.15, "share of the triangles in the energy; more and less are tried", minimum=0.0, maximum=10.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PartitionConfig(Config):
    """How a shape becomes goals."""

    method: Method = setting(Method.BUBBLE_PACKING, "partition method")
    extension: str | None = setting(
        None, "instead of `method`: a method that an installed package adds, by its name (docs/extending.md)"
    )
    gaps: Gaps = section(Gaps, "least free distances")
    bubbles: BubbleConfig = section(BubbleConfig, "tuning of bubble packing")
    fractals: FractalConfig = section(FractalConfig, "tuning of randomized fractals")
    voronoi: VoronoiConfig = section(VoronoiConfig, "tuning of the centroidal Voronoi partition")

    @property
    def name(self) -> str:
        """Name of the method that is used."""
        return self.extension or self.method.value
