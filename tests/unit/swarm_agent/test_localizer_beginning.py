"""A robot that was not told where it stands finds out from neighbors, and claims no more than it knows."""

from __future__ import annotations

import numpy as np
import pytest
from builders import make_presence
from scipy.stats import chi2

from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.hypotheses import widest
from swarm_agent.localization.localizer import Localizer
from swarm_msgs_py.messages.sensing import ImuSample, RangeScan
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import NodeId

STILL = ImuSample(np.zeros(2), 0.0, 0.0)
ROUNDS, RUNS = 30, 25


def among(
    seed: int,
    radios: int,
    beacons: int = 0,
    *,
    spread: float = 12.0,
    sigma: float = 0.3,
    shared: float = 0.5,
    mode: LpsMode = LpsMode.COOPERATIVE,
    rounds: int = ROUNDS,
) -> tuple[Estimate | None, np.ndarray]:
    """Return what a robot believes after a while among radios that are as wrong as they say, and the truth."""
    rng = rng_for(seed, "beginning", radios, beacons)
    truth, places = rng.uniform(-0.5, 0.5, 2) * spread, rng.uniform(-1.0, 1.0, (radios, 2)) * spread
    is_beacon = np.arange(radios) < beacons
    together, alone = (sigma * np.sqrt(part) for part in (shared, 1.0 - shared))
    wrong = together * rng.normal(size=2) + alone * rng.normal(size=(radios, 2))
    claims = places + np.where(is_beacon[:, None], 0.02 * rng.normal(size=(radios, 2)), wrong)
    localizer = Localizer(LpsConfig(mode=mode), 0.5)
    for tick in range(rounds):
        heard = {
            NodeId(n + 2): make_presence(
                *claims[n],
                0.02 if is_beacon[n] else sigma,
                shared=0.0 if is_beacon[n] else shared,
                is_beacon=bool(is_beacon[n]),
                tick=tick,
            )
            for n in range(radios)
        }
        ranges = np.maximum(np.linalg.norm(places - truth, axis=1) + 2.0 * rng.normal(size=radios), 0.0)
        estimate = localizer.step(tick, STILL, None, RangeScan(np.arange(radios) + 2, ranges), heard, told=np.zeros(2))
    return estimate, truth


def test_two_beacons_and_six_neighbors_that_know_their_place_are_enough() -> None:
    for seed in range(5):
        estimate, truth = among(seed, 8, 2, sigma=0.05)

        assert estimate is not None
        assert np.hypot(*(estimate.position - truth)) < 1.0
        assert widest(estimate.covariance) < 0.6


@pytest.mark.parametrize(
    ("radios", "beacons", "sigma", "shared"),
    [(1, 1, 0.3, 0.0), (2, 1, 0.3, 0.5), (3, 2, 0.3, 0.3), (4, 0, 0.3, 0.5), (12, 0, 0.8, 0.9)],
)
def test_who_begins_among_neighbors_claims_no_more_than_it_knows(
    radios: int, beacons: int, sigma: float, shared: float
) -> None:
    inside = 0
    for seed in range(RUNS):
        estimate, truth = among(seed, radios, beacons, sigma=sigma, shared=shared)
        assert estimate is not None
        error = estimate.position - truth
        inside += error @ np.linalg.solve(estimate.covariance, error) < chi2.ppf(0.95, 2)

    assert inside >= 0.85 * RUNS


def test_what_neighbors_are_wrong_about_together_is_shared() -> None:
    estimate, _ = among(1, 12, sigma=0.8, shared=0.9)

    assert estimate is not None
    assert estimate.shared > 0.5


def test_three_beacons_that_span_the_plane_are_a_fix() -> None:
    estimate, _ = among(1, 3, 3, rounds=1)

    assert estimate is not None
    assert estimate.is_corrected
    assert not among(1, 3, 2, rounds=1)[0].is_corrected  # type: ignore[union-attr]


@pytest.mark.parametrize("radios", [1, 2])
def test_one_or_two_neighbors_tell_a_robot_about_where_it_is_and_it_knows_that_this_is_little(radios: int) -> None:
    for seed in range(10):
        estimate, _ = among(seed, radios, 1)
        assert estimate is not None
        assert widest(estimate.covariance) > LpsConfig().lost.sigma_max_m


def test_as_long_as_nobody_knows_where_it_is_a_robot_waits() -> None:
    assert among(1, 6, sigma=1.1)[0] is None


@pytest.mark.parametrize("mode", [LpsMode.LITERAL, LpsMode.FIXES, LpsMode.RANGE_EKF])
def test_the_other_modes_begin_from_beacons_alone(mode: LpsMode) -> None:
    assert among(1, 8, 2, mode=mode)[0] is None
