"""Gains for the boats' controllers, found the same way for both laws, on weather that the study does not use.

LADRC and PID are optimized by differential evolution over their free numbers, eight each, for the same cost on the same
boat, curves, wind, waves and noise. The third set of gains is what the paper used: Ziegler and Nichols' rule from the
ultimate gain of the boat's own model.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq, differential_evolution

from studies.tracking_curves import CurveKind
from studies.tracking_trial import Maker, drive, scores_of
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import BoatsConfig
from swarm_sim.boats.ladrc import Bandwidths, Ladrc, LadrcGains
from swarm_sim.boats.pose_pid import PidGains, PosePid

TRAINING_SEEDS = (10_001, 10_002, 10_003)
POSITION_UNIT_M, HEADING_UNIT_RAD, CONVERGENCE_UNIT_S = 0.005, np.radians(0.5), 5.0
"""Errors and time that cost as much as each other."""
CONVERGENCE_MAX_S = 60.0
"""What a boat that does not converge is charged [s]."""
GENERATIONS, POPULATION_PER_NUMBER = 40, 6

PID_BOUNDS = ((0.5, 60.0), (0.05, 60.0), (0.5, 30.0), (0.01, 0.5)) * 2
"""P, I, D and filter of the plane, then of the heading."""
LADRC_BOUNDS = ((0.5, 20.0), (2.0, 60.0), (0.5, 2.0), (1.0, 8.0)) * 2
"""Control and observer bandwidth [rad/s], damping and thruster lead of the plane, then of the heading."""

Bounds = Sequence[tuple[float, float]]


def pid_of(numbers: FloatArray) -> PidGains:
    """Return the gains that eight numbers stand for."""
    p, i, d, filter_s, yaw_p, yaw_i, yaw_d, yaw_filter_s = numbers.tolist()
    return PidGains((p, i, d), (yaw_p, yaw_i, yaw_d), filter_s, yaw_filter_s)


def ladrc_of(numbers: FloatArray) -> LadrcGains:
    """Return the gains that eight numbers stand for."""
    return LadrcGains.of_bandwidths(Bandwidths(*numbers[:4].tolist()), Bandwidths(*numbers[4:].tolist()))


def pid_maker(table: FloatArray) -> Maker:
    """Return a maker of one PID per row of numbers, each for all training seeds."""
    gains = [pid_of(row) for row in np.repeat(table, len(TRAINING_SEEDS), axis=0)]
    return lambda poses, step_s: PosePid(gains, poses, step_s)


def ladrc_maker(table: FloatArray) -> Maker:
    """Return a maker of one LADRC per row of numbers, each for all training seeds."""
    gains = [ladrc_of(row) for row in np.repeat(table, len(TRAINING_SEEDS), axis=0)]
    return lambda poses, step_s: Ladrc(gains, poses, step_s)


def costs(config: BoatsConfig, table: FloatArray, maker: Callable[[FloatArray], Maker]) -> FloatArray:
    """Return the cost of each row of numbers, the mean over curves and training seeds."""
    seeds = TRAINING_SEEDS * len(table)
    total = np.zeros(len(table))
    for kind in CurveKind:
        scores = scores_of(drive(config, kind, seeds, maker(table)))
        cost = scores.position_m / POSITION_UNIT_M + scores.heading_rad / HEADING_UNIT_RAD
        cost += np.minimum(scores.convergence_s, CONVERGENCE_MAX_S) / CONVERGENCE_UNIT_S
        total += cost.reshape(len(table), -1).mean(axis=1)
    return total / len(CurveKind)


def optimized(config: BoatsConfig, bounds: Bounds, maker: Callable[[FloatArray], Maker]) -> tuple[FloatArray, float]:
    """Return the numbers of least cost within bounds, and that cost; the search is in their logarithms."""
    found = differential_evolution(
        lambda columns: costs(config, np.exp(columns.T), maker),
        np.log(np.array(bounds)),
        maxiter=GENERATIONS,
        popsize=POPULATION_PER_NUMBER,
        rng=np.random.default_rng(7),
        polish=False,
        vectorized=True,
        updating="deferred",
        init="sobol",
    )
    return np.exp(found.x), float(found.fun)


def ziegler_nichols(mass: float, drag: float, lag_s: float, step_s: float) -> tuple[float, float, float, float]:
    """Return P, I, D and filter for one axis, by the classic rule from the ultimate gain and period.

    Parameters
    ----------
    mass, drag : float
        Of ``mass v' = force - drag v``.
    lag_s, step_s : float
        Thruster lag and control step [s].
    """
    flow = np.zeros((4, 4))  # position, velocity, force / mass, command / mass
    flow[0, 1], flow[1, 1], flow[1, 2], flow[2, 2], flow[2, 3] = 1.0, -drag / mass, 1.0, -1.0 / lag_s, 1.0 / lag_s
    sampled = expm(flow * step_s)

    def poles(gain: float) -> FloatArray:
        return np.asarray(np.linalg.eigvals(sampled[:3, :3] - np.outer(sampled[:3, 3], [gain, 0.0, 0.0])))

    ultimate = float(brentq(lambda gain: np.abs(poles(gain)).max() - 1.0, 1e-3, 1e3))
    turning = max(poles(ultimate), key=lambda pole: abs(pole.imag))
    period = 2.0 * np.pi * step_s / abs(np.angle(turning))
    p = 0.6 * ultimate
    return p, 2.0 * p / period, p * period / 8.0, period / 64.0


def main(argv: Sequence[str] | None = None) -> int:
    """Print the gains, as `gains.py` holds them; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.parse_args(argv)
    config = BoatsConfig()
    bandwidths, ladrc_cost = optimized(config, LADRC_BOUNDS, ladrc_maker)
    print(f"LADRC, cost {ladrc_cost:.3f}: {', '.join(f'{x:.3g}' for x in bandwidths)}", flush=True)
    gains, pid_cost = optimized(config, PID_BOUNDS, pid_maker)
    print(f"PID, cost {pid_cost:.3f}: {', '.join(f'{x:.3g}' for x in gains)}", flush=True)
    hull, lag_s, step_s = config.hull, config.thrusters.lag_s, 1.0 / config.control_hz
    planar = ziegler_nichols(hull.mass_kg, hull.drag_nspm, lag_s, step_s)
    yaw = ziegler_nichols(hull.inertia_kgm2, hull.yaw_drag_nms, lag_s, step_s)
    print(f"Ziegler-Nichols: {', '.join(f'{x:.3g}' for x in (*planar, *yaw))}")
    print(f"its cost: {costs(config, np.array([[*planar, *yaw]]), pid_maker)[0]:.3f}")
    return 0
