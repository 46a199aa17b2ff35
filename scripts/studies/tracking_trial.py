"""One boat per seed drives a curve under wind and waves; how far off it is, how soon it gets there, what it costs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.tracking_curves import SPEED_MPS, Curve, CurveKind, reference_of
from swarm_msgs_py.types import FloatArray
from swarm_sim.boats.config import BoatsConfig, HullConfig, WaterConfig
from swarm_sim.boats.firmware import Firmware, PoseSensor
from swarm_sim.boats.planar_bodies import PlanarBodies
from swarm_sim.boats.pose_control import PoseController, pose_error
from swarm_sim.boats.water import Water

START_HEADING_RAD = np.pi / 4.0
"""Heading of a boat at the start, in the middle of the pool; it is to be 0."""
SETTLING_S = 25.0
"""Errors count as those of tracking from here on [s]."""
CONVERGED_M, CONVERGED_RAD = 0.05, np.radians(3.0)
"""A boat has converged once both errors stay below these [m], [rad] ..."""
CONVERGED_S = 3.0
"""... for as long as this [s]."""

Maker = Callable[[FloatArray, float], PoseController]


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """What n boats did.

    Attributes
    ----------
    times : (k,) array
        [s]
    wanted : (k, 2) array
        Point of the curve [m].
    poses : (k, n, 3) array
    thrusts : (k, n, 4) array
        [N]
    """

    times: FloatArray
    wanted: FloatArray
    poses: FloatArray
    thrusts: FloatArray

    @property
    def position_errors(self) -> FloatArray:
        """Distance to the point of the curve (k, n) [m]."""
        return np.asarray(np.linalg.norm(self.poses[:, :, :2] - self.wanted[:, None], axis=2))

    @property
    def heading_errors(self) -> FloatArray:
        """Absolute heading (k, n) [rad]; the wanted one is 0."""
        flat = self.poses.reshape(-1, 3)
        return np.abs(pose_error(flat, np.zeros_like(flat))[:, 2]).reshape(self.poses.shape[:2])


@dataclass(frozen=True, slots=True, eq=False)
class Scores:
    """Numbers of each seed, (n,).

    Attributes
    ----------
    position_m, heading_rad : (n,) array
        Mean absolute error of tracking.
    position_all_m, heading_all_rad : (n,) array
        The same, the approach to the curve included.
    convergence_s : (n,) array
        Infinite for a boat that did not converge.
    energy_n2s : (n,) array
        Integral of the squared thrusts [N^2 s].
    """

    position_m: FloatArray
    heading_rad: FloatArray
    position_all_m: FloatArray
    heading_all_rad: FloatArray
    convergence_s: FloatArray
    energy_n2s: FloatArray


def duration_s(curve: Curve) -> float:
    """Return how long a trial takes: the approach and one round [s]."""
    return SETTLING_S + curve.length_m / SPEED_MPS


def scaled_weather(water: WaterConfig, factor: float) -> WaterConfig:
    """Return water whose wind, gusts and waves are so many times as strong."""
    return replace(
        water,
        wind_n=factor * water.wind_n,
        gust_n=factor * water.gust_n,
        gust_yaw_nm=factor * water.gust_yaw_nm,
        wave_n=factor * water.wave_n,
        wave_yaw_nm=factor * water.wave_yaw_nm,
    )


def scaled_hull(hull: HullConfig, factor: float) -> HullConfig:
    """Return a hull with so many times the mass, inertia and drag."""
    return replace(
        hull,
        dry_mass_kg=factor * hull.dry_mass_kg,
        added_mass_kg=factor * hull.added_mass_kg,
        inertia_kgm2=factor * hull.inertia_kgm2,
        drag_nspm=factor * hull.drag_nspm,
        yaw_drag_nms=factor * hull.yaw_drag_nms,
    )


def drive(
    config: BoatsConfig, kind: CurveKind, seeds: Sequence[int], make: Maker, hull: HullConfig | None = None
) -> Track:
    """Return the tracks of one boat per seed.

    Parameters
    ----------
    config : BoatsConfig
    kind : CurveKind
    seeds : sequence of int
        Of wind, waves and measurement noise.
    make : callable
        Makes a controller from first measured poses and the control step.
    hull : HullConfig, optional
        The true one, if it is not the one that the firmware and the gains were made for.
    """
    curve = Curve(kind)
    count, step_s = len(seeds), 1.0 / config.control_hz
    times = np.arange(round(duration_s(curve) * config.control_hz), dtype=np.float64) * step_s
    rows = curve.references(times)
    start = np.tile([0.0, 0.0, START_HEADING_RAD], (count, 1))
    bodies = PlanarBodies(hull or config.hull, start, step_s)
    water = Water(config.water, seeds, [0] * count, step_s)
    sensor = PoseSensor(config.pose, seeds, [0] * count)
    first = sensor.measure(bodies.poses)
    firmware = Firmware(config, first, step_s, make(first, step_s))
    free, powered = np.zeros(count, dtype=np.bool_), np.ones(count, dtype=np.bool_)
    poses, thrusts = np.empty((len(times), count, 3)), np.empty((len(times), count, 4))
    for k, row in enumerate(rows):
        poses[k] = bodies.poses
        push = firmware.wrenches(sensor.measure(bodies.poses), reference_of(row, count), free, powered)
        thrusts[k] = firmware.thrusts
        bodies.step(push + water.wrenches(bodies.poses))
    return Track(times, rows[:, :2], poses, thrusts)


def scores_of(track: Track) -> Scores:
    """Return the numbers of a trial."""
    step_s = float(track.times[1] - track.times[0])
    position, heading = track.position_errors, track.heading_errors
    late = track.times >= SETTLING_S
    good = (position < CONVERGED_M) & (heading < CONVERGED_RAD)
    return Scores(
        position_m=position[late].mean(axis=0),
        heading_rad=heading[late].mean(axis=0),
        position_all_m=position.mean(axis=0),
        heading_all_rad=heading.mean(axis=0),
        convergence_s=np.array([_first_stay(column, round(CONVERGED_S / step_s)) for column in good.T]) * step_s,
        energy_n2s=(track.thrusts**2).sum(axis=(0, 2)) * step_s,
    )


def _first_stay(good: np.ndarray[tuple[int], np.dtype[np.bool_]], length: int) -> float:
    """Return the first index from which `good` holds for `length` entries; infinite if there is none."""
    sums = np.concatenate([[0], np.cumsum(good)])
    stays = np.flatnonzero(sums[length:] - sums[:-length] == length)
    return float(stays[0]) if len(stays) else float("inf")
