"""Where a rule puts robots if placement is exact and no message is needed: how many, and how long that takes."""

from __future__ import annotations

import time

import numpy as np

from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.expansion import expand
from swarm_agent.coverage.layout import plan_layout
from swarm_msgs_py.geometry.solids.solid import Solid
from swarm_msgs_py.randomness import rng_for
from swarm_sim.metrics.coverage import CoverageProbe

PLAN_HEADER = "experiment  rule    seeds robots            covered  CPU, mean and max"
ROBOTS_MAX = 1000


def plan_row(name: str, solid: Solid, config: CoverageConfig, seeds: int) -> str:
    """Return the line on the places of followers that the rule of `config` finds for a leader at the origin.

    Parameters
    ----------
    name : str
        Of the experiment.
    solid : Solid
    config : CoverageConfig
    seeds : int
        How many plans are made.
    """
    probe = CoverageProbe(solid, config.range_m, seed=0)
    counts, shares, times = [], [], []
    for seed in range(seeds):
        began = time.process_time()
        if config.rule is Rule.LAYOUT:
            plan = plan_layout(solid, np.zeros(3), config, seed)
        else:
            plan = expand(solid, np.zeros(3), config, ROBOTS_MAX, rng_for(seed, "coverage", "plan"))
        times.append(time.process_time() - began)
        counts.append(len(plan.positions) - 1)
        shares.append(probe.measure(plan.positions).covered_fraction)
    return (
        f"{name:11s} {config.rule.value:7s} {seeds:5d} {np.mean(counts):5.2f} ({min(counts)}-{max(counts)})"
        f"      {np.mean(shares):.5f}  {np.mean(times):.2f} s, {max(times):.2f} s"
    )
