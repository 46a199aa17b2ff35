"""Message-level swarms of the coverage family for tests: few robots, short ranges, cheap layouts."""

from __future__ import annotations

from typing import Any

from studies.coverage_mission import CoverageMission
from swarm_agent.coverage.config import CoverageConfig, Expansion, LayoutConfig, MotionConfig, Rule
from swarm_sim.points.config import PointSimConfig

BEAM: dict[str, Any] = {"kind": "box", "size_m": [160.0, 50.0, 50.0]}
CHEAP = LayoutConfig(interior_points=400, surface_points=400, judged_points=3000, kicks=2, covered_fraction=0.999)


def mission(
    rule: Rule = Rule.LAYOUT,
    expansion: Expansion = Expansion.PREDICTED,
    *,
    shape: dict[str, Any] = BEAM,
    robots: int = 24,
    sigma_m: float = 1.0,
    seed: int = 0,
    world: PointSimConfig | None = None,
    **options: Any,
) -> CoverageMission:
    """Return a mission of robots that link and cover at 50 m; options are those of `CoverageMission`."""
    agents = CoverageConfig(
        rule=rule,
        expansion=expansion,
        placement=0.95 if sigma_m == 0.0 else 0.9,
        sample_count=150,
        motion=MotionConfig(sigma_m=sigma_m),
        layout=CHEAP,
    )
    world = world or PointSimConfig(process_sigma_m=sigma_m)
    return CoverageMission(shape, agents, world, robots, seed, **options)
