"""Which frontier point becomes the next target [I8]; none of the rules depends on the last bits of a number."""

from __future__ import annotations

import numpy as np

from swarm_agent.coverage.config import CoverageConfig, Rule
from swarm_agent.coverage.gain import best_place
from swarm_agent.coverage.sites import Choice, Site


def choose(config: CoverageConfig, site: Site, rng: np.random.Generator) -> Choice:
    """Return where the next robot is to go, next to the robot of `site`.

    What `Rule.LAYOUT` wants stands in the layout, so that it counts as `Rule.GAIN` here.

    Parameters
    ----------
    config : CoverageConfig
        Range, placement and rule.
    site : Site
    rng : Generator
        Decides ties, and where `Rule.GAIN` looks.
    """
    if config.rule in {Rule.FIRST, Rule.RANDOM}:
        row = 0 if config.rule is Rule.FIRST else int(rng.integers(len(site.own)))
        return Choice(row, config.placement * site.own[row])
    return best_place(config, site, rng)
