"""A crowd of discs under the collision avoidance: the smallest world in which it can be tried."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import pdist, squareform

from swarm_agent.control.avoidance import Avoidance
from swarm_agent.control.config import AvoidanceConfig, YieldingConfig
from swarm_agent.control.yielding import make_way
from swarm_msgs_py.types import FloatArray

PERIOD = 0.5
SPEED = 0.5
SENSING = 3.0
NATURAL_FREQUENCY, DAMPING = 11.9, 0.707  # of the recommended velocity servo, spec 12.2
SUBSTEPS = 50


@dataclass(frozen=True)
class CrowdResult:
    """What came of it."""

    arrived_after: float | None  # [s]
    min_gap: float  # [m]
    detour: float  # traveled length / straight length


def move_crowd(
    starts: FloatArray, goals: FloatArray, radii: FloatArray, *, deadline: float = 200.0, seed: int = 0
) -> CrowdResult:
    """Drive every disc to its goal with proximity sensing alone; stops when all have arrived."""
    rng = np.random.default_rng(seed)
    minds = [Avoidance(AvoidanceConfig(), float(r), PERIOD) for r in radii]
    positions, velocities, errors = starts.copy(), np.zeros_like(starts), np.zeros_like(starts)
    min_gap, traveled, blocked = np.inf, 0.0, np.zeros(len(starts), dtype=bool)
    straight = np.hypot(*(goals - starts).T).sum()
    for tick in range(int(deadline / PERIOD)):
        commands = np.array(
            [_command(i, positions, velocities, goals, radii, minds[i], blocked, rng) for i in range(len(starts))]
        )
        blocked = np.array([mind.is_blocked for mind in minds])
        for _ in range(SUBSTEPS):
            step = PERIOD / SUBSTEPS
            errors += (commands - velocities) * step
            velocities += (NATURAL_FREQUENCY**2 * errors - 2 * DAMPING * NATURAL_FREQUENCY * velocities) * step
            positions += velocities * step
            traveled += np.hypot(*velocities.T).sum() * step
            min_gap = min(min_gap, _smallest_gap(positions, radii))
        if (np.hypot(*(goals - positions).T) < 0.15).all():
            return CrowdResult((tick + 1) * PERIOD, min_gap, traveled / straight)
    return CrowdResult(None, min_gap, traveled / straight)


def _command(
    i: int,
    positions: FloatArray,
    velocities: FloatArray,
    goals: FloatArray,
    radii: FloatArray,
    mind: Avoidance,
    blocked: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    offsets = positions - positions[i]
    distances = np.hypot(*offsets.T)
    seen = (distances - radii < SENSING) & (np.arange(len(radii)) != i)
    contacts = offsets[seen] * (1.0 - radii[seen] / distances[seen])[:, None] + rng.normal(0.0, 0.005, (seen.sum(), 2))
    to_goal = goals[i] - positions[i]
    reach = float(np.hypot(*to_goal))
    wanted = to_goal * min(1.0, SPEED / reach) if reach > 0.05 else np.zeros(2)
    asking = blocked & (np.arange(len(radii)) != i)
    if reach < 2.0 and not blocked[i]:
        aside = make_way(positions[i], goals[i], positions[asking], YieldingConfig())
        wanted, reach = (aside, 1.2) if aside is not None else (wanted, reach)
    return mind.step(wanted, velocities[i], contacts, reach)


def _smallest_gap(positions: FloatArray, radii: FloatArray) -> float:
    gaps = squareform(pdist(positions)) - radii[:, None] - radii
    np.fill_diagonal(gaps, np.inf)
    return float(gaps.min())
