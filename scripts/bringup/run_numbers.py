"""Numbers of a run that do not depend on what the robots do: its name and outcome, times, ways and radio traffic."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from bringup.family import AnyScenario
from bringup.verdict import Timing, Verdict
from swarm_msgs_py.types import FloatArray
from swarm_sim.ticked_world import Truth


class MovingTruth(Truth, Protocol):
    """Truth of a tick that says where the robots are when it is over."""

    @property
    def ends(self) -> FloatArray:
        """Where the robots are at the end of the tick, as `positions` [m]."""
        ...


def run_numbers(
    scenario: AnyScenario, truths: Sequence[MovingTruth], engine: str, verdict: Verdict, timing: Timing
) -> dict[str, Any]:
    """Return the numbers by key, as ``metrics.json`` has them; a family writes over those that it knows more of.

    Parameters
    ----------
    scenario : AnyScenario
    truths : sequence of MovingTruth
        Of all ticks.
    engine : str
    verdict : Verdict
    timing : Timing
    """
    sim_time = len(truths) * scenario.period_s
    return {
        "scenario": scenario.name,
        "family": scenario.family.value,
        "method": None,
        "seed": scenario.seed,
        "engine": engine,
        "physics": None,
        "robots": scenario.robot_count,
        "achieved": verdict.achieved,
        "reason": verdict.reason,
        "ticks": len(truths),
        "sim_time_s": sim_time,
        "wall_time_s": timing.wall_time_s,
        "real_time_factor": sim_time / timing.wall_time_s if timing.wall_time_s > 0.0 else None,
        "startup_s": timing.startup_s,
        "total_displacement_m": sum(
            float(np.linalg.norm(truth.ends - truth.positions, axis=1).sum()) for truth in truths
        ),
        "displacement_lower_bound_m": None,
        "settling_time_s": None,
        "collisions": 0,
        "min_clearance_m": None,
        "localization_rmse_m": None,
        "localization_max_m": None,
        "radio_frames": sum(truth.radio.frames for truth in truths),
        "radio_bytes": sum(truth.radio.bytes for truth in truths),
        "radio_peak_bps": max((truth.radio.peak_bps for truth in truths), default=0.0),
        "radio_neighborhood_peak_bps": max((truth.radio.neighborhood_bps for truth in truths), default=0.0),
        "radio_dropped_frames": sum(truth.radio.dropped for truth in truths),
        "lost_robots": 0,
    }
