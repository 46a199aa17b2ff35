"""Message-level swarms of the coverage family for tests: few robots, short ranges, cheap layouts."""

from __future__ import annotations

from typing import Any

from studies.coverage_mission import CoverageMission
from swarm_agent.coverage.config import CoverageConfig, Expansion, LayoutConfig, MotionConfig, Rule
from swarm_msgs_py.types import FloatArray
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
    newcomers: FloatArray | None = None,
    appear_at: int = 0,
) -> CoverageMission:
    """Return a mission of robots that link and cover at 50 m."""
    agents = CoverageConfig(
        rule=rule,
        expansion=expansion,
        placement=0.95 if sigma_m == 0.0 else 0.9,
        sample_count=150,
        motion=MotionConfig(sigma_m=sigma_m),
        layout=CHEAP,
    )
    return CoverageMission(
        shape, agents, PointSimConfig(process_sigma_m=sigma_m), robots, seed, newcomers=newcomers, appear_at=appear_at
    )
