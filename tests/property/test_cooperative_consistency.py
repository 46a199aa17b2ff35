"""Many filters that range to each other: errors are as large as they claim, with beacons and without any."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import chi2

from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray, NodeId

DT, TICKS, SETTLED = 0.5, 120, 20
ROBOTS = 12
# Three beacons that span the formation, and nine robots between them [m].
PLACES = np.array(
    [[9, 0], [-5, 8], [-5, -8], [0, 0], [4, 0], [-2, 4], [-2, -4], [5, 5], [5, -5], [-7, 0], [1, 8], [1, -8]],
    dtype=float,
)
CONFIG = LpsConfig()
BAND = chi2.ppf(0.95, 2)


@dataclass(frozen=True)
class Outcome:
    """Errors [m], normalized squared errors and claimed deviations [m] of all robots but beacons, (runs, ticks, k)."""

    errors: FloatArray
    squares: FloatArray
    claims: FloatArray

    @property
    def rms(self) -> float:
        """Of the errors, after the first ten seconds [m]."""
        return float(np.sqrt((self.errors[:, SETTLED:] ** 2).mean()))

    @property
    def share_inside(self) -> float:
        """Share of the robots and ticks in which the error lies within the ellipse that should hold 95 % of them."""
        return float((self.squares < BAND).mean())


@cache
def play(mode: LpsMode, beacons: int, runs: int, *, naive: bool = False, knows_commands: bool = False) -> Outcome:
    """Let twelve robots wander for a minute; hellos arrive a tick late.

    The naive variant takes every neighbor for a beacon with the covariance that it claims. Who knows its commands, as
    all robots do in a mission, has hardly any process noise: nothing that was counted twice is ever forgotten.
    """
    tracks = [_run(mode, beacons, run, naive=naive, knows_commands=knows_commands) for run in range(runs)]
    errors, squares, claims = (np.array(columns) for columns in zip(*tracks, strict=True))
    return Outcome(errors, squares, claims)


def _run(
    mode: LpsMode, beacons: int, run: int, *, naive: bool, knows_commands: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    rng = rng_for(11, "formation", run)
    config = replace(CONFIG, mode=LpsMode.RANGE_EKF if naive else mode)
    positions, velocities = PLACES + rng.normal(0.0, 0.5, PLACES.shape), np.zeros((ROBOTS, 2))
    biases = rng.uniform(-9.8e-4, 9.8e-4, (ROBOTS, 2))
    starts = positions + 2.0 * rng.normal(size=(ROBOTS, 2))
    localizers = [
        Localizer(config, DT, None if robot < beacons else PositionFix(starts[robot], 2.0)) for robot in range(ROBOTS)
    ]
    told: dict[NodeId, Presence] = {}
    track = np.empty((3, TICKS, ROBOTS - beacons))
    for tick in range(TICKS):
        pushes = rng.uniform(-0.2, 0.2, (ROBOTS, 2)) - 0.5 * velocities - 0.02 * (positions - PLACES)
        positions = positions + DT * velocities + DT * (DT - config.push_delay_s) * pushes
        velocities = velocities + DT * pushes
        distances = np.linalg.norm(positions[:, None] - positions, axis=2)
        ranges = np.maximum(distances + config.range_sigma * rng.normal(size=distances.shape), 0.0)
        slips = 0.003 * rng.normal(size=(ROBOTS, 2))
        imu_noise, fix_noise = 0.01 * rng.normal(size=(ROBOTS, 2)), 0.02 * rng.normal(size=(ROBOTS, 2))
        heard, told = told, {}
        for robot, localizer in enumerate(localizers):
            others = np.delete(np.arange(ROBOTS), robot)
            estimate = localizer.step(
                tick,
                ImuSample(pushes[robot] + biases[robot] + imu_noise[robot], 0.0, 0.0),
                PositionFix(positions[robot] + fix_noise[robot], 0.02) if robot < beacons else None,
                RangeScan(others, ranges[robot, others]),
                heard,
                told=velocities[robot] + slips[robot] if knows_commands else None,
            )
            assert estimate is not None
            told[NodeId(robot)] = Presence(
                estimate.position,
                estimate.velocity,
                estimate.covariance,
                0.0 if naive else estimate.shared,
                tick,
                robot_type=1,
                is_beacon=naive or localizer.is_beacon,
                mode=0,
                epoch=0,
                digest=0,
            )
            if robot >= beacons:
                error = estimate.position - positions[robot]
                squared = error @ np.linalg.solve(estimate.covariance, error)
                claim = np.sqrt(np.trace(estimate.covariance))
                track[:, tick, robot - beacons] = np.hypot(*error), squared, claim
    return track[0], track[1], track[2]


@pytest.mark.parametrize("knows_commands", [False, True])
def test_cooperation_is_consistent_and_better_than_ranging_to_beacons_alone(knows_commands: bool) -> None:
    together = play(LpsMode.COOPERATIVE, 3, 2, knows_commands=knows_commands)
    apart = play(LpsMode.RANGE_EKF, 3, 2, knows_commands=knows_commands)

    assert together.share_inside >= 0.9
    assert apart.share_inside >= 0.9
    assert together.rms < apart.rms
    if not knows_commands:
        assert together.rms < 0.9 * apart.rms


@pytest.mark.parametrize(("beacons", "knows_commands"), [(0, False), (0, True), (1, True)])
def test_with_hardly_any_beacon_the_claims_stay_honest(beacons: int, knows_commands: bool) -> None:
    outcome = play(LpsMode.COOPERATIVE, beacons, 2, knows_commands=knows_commands)

    assert outcome.share_inside >= 0.9
    assert (outcome.squares[:, -20:] < BAND).mean() >= 0.9  # and no worse at the end


def test_cooperation_without_beacons_is_worth_having() -> None:
    together, alone = play(LpsMode.COOPERATIVE, 0, 2), play(LpsMode.RANGE_EKF, 0, 2)

    assert together.rms < alone.rms
    assert together.claims[:, 4].mean() < 0.8 * alone.claims[:, 4].mean()


def test_taking_neighbors_for_beacons_fails_by_far() -> None:
    naive = play(LpsMode.COOPERATIVE, 0, 2, naive=True)

    assert naive.share_inside < 0.4
    assert naive.squares[:, -1].mean() > 10.0 * 2.0


def test_even_with_beacons_the_naive_filter_is_too_sure() -> None:
    naive = play(LpsMode.COOPERATIVE, 3, 2, naive=True)

    assert naive.share_inside < 0.85
