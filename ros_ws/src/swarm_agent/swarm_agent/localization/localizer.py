"""A robot's own position and velocity: dead reckoning at every tick, corrected by fixes and ranges."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from swarm_agent.localization.beginning import begin_among
from swarm_agent.localization.camera_fixes import AGE_TICKS_MAX, SeenFrom, Trail
from swarm_agent.localization.config import LpsConfig, LpsMode
from swarm_agent.localization.estimate import Estimate
from swarm_agent.localization.hypotheses import Hypotheses, Hypothesis, certain, divided, merged, reweighed
from swarm_agent.localization.kalman import Gaussian, correct, innovation, predict
from swarm_agent.localization.motion_model import (
    OBSERVE_POSITION,
    OBSERVE_VELOCITY,
    POSITION,
    VELOCITY,
    MotionModel,
    Step,
    belief_at,
    restarted,
)
from swarm_agent.localization.observations import RangeObservations, observe
from swarm_agent.localization.range_fusion import (
    Fusion,
    RangeModel,
    SplitBelief,
    fixed,
    fuse_beacons,
    fuse_neighbors,
    predicted,
)
from swarm_agent.localization.surroundings import Surroundings
from swarm_agent.localization.trilateration import MIN_BEACONS, Trilateration, dilution, trilaterate
from swarm_agent.planar import length_of
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.types import FloatArray, NodeId

MIN_SIGMA = 1e-4  # no position sensor is better [m]; keeps the filter regular when noise is switched off
BEACON_MEMORY_S = 3.0  # a sensor that has said nothing usable for that long makes no beacon any more
ACCELERATION_MAX_MPS2, YAW_MAX_RAD = 100.0, 1e6  # whatever measures more than that is broken
DOUBT_SHARE = 0.5  # a round in which more than this share of the ranges are outliers speaks against the filter

_log = logging.getLogger(__name__)
_UNIT_NOISE: FloatArray = np.eye(2)
_NO_IDEA: FloatArray = np.diag([math.inf, math.inf])
_NO_POINTS: FloatArray = np.empty((0, 2))


class Localizer:
    """Kalman filter of one robot (thesis eqs. (3.28)-(3.44)) in one of the modes of `LpsMode`.

    A robot with a position sensor uses its fixes; without one, or when it is silent, ranges to the neighbors.

    Parameters
    ----------
    config : LpsConfig
    period_s : float
        Control period [s].
    start : PositionFix or None
        Where the robot was told to stand at the start, with its standard deviation; None: it has to find out.
    walls : sequence of (k, 2) array
        Obstacles whose place is certain [m]. If there is none, those of the plan are taken for certain (see `learn`).
    """

    def __init__(
        self,
        config: LpsConfig,
        period_s: float,
        start: PositionFix | None = None,
        walls: Sequence[FloatArray] = (),
    ) -> None:
        self._config = config
        self._period = period_s
        self._every = max(1, round(config.period_s / period_s))
        self._model = MotionModel(
            period_s,
            config.acceleration_sigma_mps2,
            config.yaw_sigma_rad,
            config.push_delay_s,
            config.push_delay_sigma_s,
        )
        self._ranges = RangeModel(config.range_sigma, config.range_gate_chi_square, config.covariance_inflation)
        self._hypotheses: Hypotheses = ()  # none: the position is unknown
        if start is not None:
            self._begin(start.position, start.sigma**2 * _UNIT_NOISE, config.initial_speed_sigma_mps)
        is_literal = config.mode is LpsMode.LITERAL
        self._command_sigma = None if is_literal else config.command_sigma_mps
        self._lag = math.exp(-period_s / config.push_delay_s) if config.push_delay_s > 0.0 else 0.0
        self._told_before: FloatArray | None = None
        is_blind = is_literal or config.wall_sigma_m is None
        self._surroundings = None if is_blind else Surroundings(config, period_s, walls)
        self._hello_age_max = round(config.hello_age_max_s / period_s)
        self._trail = Trail(AGE_TICKS_MAX) if config.from_camera else None
        self._tick: int | None = None  # the last one
        self._due = 0  # tick of the next localization
        self._doubts = 0  # fixes, or rounds of ranging, in a row that did not fit
        self._beacon_until = -1  # tick
        self.yaw = 0.0
        """Heading by the last sample that made sense [rad]."""
        self.is_beacon = False
        """Whether the own position sensor works: it has lately given a fix that was believed."""
        self.walls: FloatArray = _NO_POINTS
        """Sensed points that were recognized as walls in this tick, (m, 2), as `proximity` in `step` [m]."""
        self.accepted = self.rejected = 0
        """Fixes and ranges used, and thrown out as outliers, since the start."""

    def step(  # noqa: PLR0913 - all that a robot measures in a tick
        self,
        tick: int,
        imu: ImuSample,
        fix: PositionFix | None,
        scan: RangeScan,
        neighbors: Mapping[NodeId, Presence],
        *,
        proximity: FloatArray = _NO_POINTS,
        told: FloatArray | None = None,
        is_blocked: bool = False,
        seen: SeenFrom | None = None,
    ) -> Estimate | None:
        """Advance by one tick, and by those that were missed since the last call.

        Parameters
        ----------
        tick : int
        imu : ImuSample
            Over the tick that ends now. One that is not finite, or absurd, counts as a missed tick.
        fix : PositionFix or None
            Taken now. A fix that is not finite counts as none.
        scan : RangeScan
            Ranges to the radio neighbors, taken now; may be empty. Used when the localization timer is due.
        neighbors : mapping
            Latest presence of the radio neighbors.
        proximity : (k, 2) array
            Nearest points of what is near, relative to the robot, axes of the world [m].
        told : (2,) array or None
            Velocity that the robot was told to drive in the tick that ends now, world frame [m/s]; None: nothing.
        is_blocked : bool
            The robot wants to drive, and has hardly got on for some time.
        seen : SeenFrom or None
            Fix that somebody else made, now or some ticks ago.

        Returns
        -------
        Estimate or None
            None as long as the position is unknown.
        """
        missed = 0 if self._tick is None else max(tick - self._tick - 1, 0)
        self._tick = tick
        before = self._place()
        self._advance(imu, told, missed)
        if self._trail is not None:
            self._trail.note(tick, self._place() - before)
        is_corrected = False
        if seen is not None:
            is_corrected = self._take_seen(tick, seen)
        elif fix is not None and math.isfinite(fix.sigma + sum(fix.position.tolist())):
            is_corrected = self._take_fix(fix.position, max(fix.sigma, MIN_SIGMA) ** 2 * _UNIT_NOISE)
            if is_corrected:
                self._beacon_until = tick + round(BEACON_MEMORY_S / self._period)
        elif len(scan.neighbors) and tick >= self._due:
            self._due = tick + self._every
            is_corrected = self._take_ranges(*observe(scan, neighbors, tick, self._period, self._hello_age_max))
        self.walls = _NO_POINTS
        if self._surroundings is not None:
            self._surroundings.hear(tick, neighbors)
            if self._hypotheses:
                look = self._surroundings.look(
                    tick, self._hypotheses, proximity, scan, neighbors, is_blocked=is_blocked
                )
                self._hypotheses, self.walls = look.hypotheses, look.faces
        self.is_beacon = tick <= self._beacon_until
        return self._estimate(is_corrected=is_corrected)

    def learn(self, walls: Sequence[FloatArray], bodies: Sequence[FloatArray]) -> None:
        """Take note of what a plan says.

        Parameters
        ----------
        walls : sequence of (k, 2) array
            Obstacles of the map [m]: landmarks, unless the robot has been given a map of its own.
        bodies : sequence of (k, 2) array
            Where lost robots may stand, as far as that is known [m].
        """
        if self._surroundings is not None:
            self._surroundings.learn(walls, bodies)

    def heading(self, imu: ImuSample) -> float:
        """Return the heading [rad] of a sample, or the last one that made sense if this one does not."""
        return imu.yaw if imu.yaw is not None and _is_sound(imu) else self.yaw

    def _estimate(self, *, is_corrected: bool) -> Estimate | None:
        if not self._hypotheses:
            return None
        belief = merged(self._hypotheses)
        mean, covariance = belief.gaussian.mean, belief.gaussian.covariance[POSITION, POSITION].copy()
        return Estimate(mean[POSITION].copy(), mean[VELOCITY].copy(), covariance, self.yaw, belief.shared, is_corrected)

    def _change(self, changed: Callable[[SplitBelief], SplitBelief]) -> None:
        """Apply to every hypothesis what tells nothing of which one is right."""
        self._hypotheses = tuple(Hypothesis(one.weight, changed(one.belief)) for one in self._hypotheses)

    def _advance(self, imu: ImuSample, told: FloatArray | None, missed: int) -> None:
        """Predict over the tick that ends now, and over ticks before it of which nothing is known.

        In those the robot may have stopped, or been pushed, and whether it did what it was told nobody knows.
        """
        yaw = imu.yaw if _is_sound(imu) else None
        unknown = missed + (yaw is None)
        if unknown:
            told = self._told_before = None
            gap = self._model.gap(unknown, self._config.restart_speed_sigma_mps)
            self._change(lambda belief: self._moved(belief, gap, None, None))
        if yaw is not None:
            self.yaw = yaw
            if self._hypotheses:
                step = self._model.step(imu.acceleration_body, yaw)
                noise = self._command_noise(told)
                self._change(lambda belief: self._moved(belief, step, told, noise))
        self._told_before = told

    def _moved(self, belief: SplitBelief, step: Step, told: FloatArray | None, noise: FloatArray | None) -> SplitBelief:
        """Return a belief one tick later.

        An accelerometer's noise becomes a velocity that grows and a position that runs away. But a robot knows what it
        told its servo, which is a measurement of the velocity, left out if the filter is sure of the contrary: when
        somebody pushes, or a wall stops it. At rest that is the zero-velocity update of inertial navigation.
        """
        ahead = predicted(belief, predict(belief.gaussian, step.transition, step.drive, step.noise), step.noise)
        if told is None or noise is None:
            return ahead
        surprise = innovation(ahead.gaussian, told - ahead.gaussian.mean[VELOCITY], OBSERVE_VELOCITY, noise)
        if surprise.squared > self._config.gate_chi_square:
            return ahead
        return fixed(ahead, correct(ahead.gaussian, surprise, OBSERVE_VELOCITY, noise))

    def _command_noise(self, told: FloatArray | None) -> FloatArray | None:
        """Return how well the velocity follows the command, (2, 2) [m^2/s^2]; None if that says nothing."""
        if told is None or self._told_before is None or self._command_sigma is None:
            return None
        # What the servo has not yet made up of the last change decays with its own time constant.
        behind = self._lag * length_of(told - self._told_before)
        return (self._command_sigma + behind) ** 2 * _UNIT_NOISE

    def _place(self) -> FloatArray:
        """Return the position believed in, zero if there is none (2,) [m]."""
        if self._trail is None or not self._hypotheses:
            return np.zeros(2)
        return merged(self._hypotheses).gaussian.mean[POSITION]

    def _take_seen(self, tick: int, seen: SeenFrom) -> bool:
        """Correct by a fix that is some ticks old; return whether it was accepted.

        It is brought forward by the way that was reckoned since then, which adds the error of that (extrapolation, as
        in Larsen et al., "Incorporation of time delayed measurements in a discrete-time Kalman filter", CDC 1998).
        """
        way = self._trail.since(seen.tick) if self._trail is not None else np.zeros(2)
        drift = (tick - seen.tick) * self._period * (self._command_sigma or self._config.initial_speed_sigma_mps)
        variance = max(seen.fix.position_sigma, MIN_SIGMA) ** 2 + drift**2
        return self._take_fix(seen.fix.position + way, variance * _UNIT_NOISE)

    def _take_ranges(self, beacons: RangeObservations, others: RangeObservations) -> bool:
        """Correct by ranges; return whether the beacons determined the position."""
        if not self._hypotheses or self._config.mode in (LpsMode.LITERAL, LpsMode.FIXES):
            is_found = self._take_trilateration(beacons)
            if not is_found and not self._hypotheses and self._config.mode is LpsMode.COOPERATIVE:
                self._begin_among(beacons, others)
            return is_found
        if self._config.mode is not LpsMode.COOPERATIVE:
            others = others.only(slice(0, 0))
        if not len(beacons) + len(others):
            return False
        several = divided(self._hypotheses)
        has_rivals = len(several) > 1
        rounds = [(one, *self._fused(one.belief, beacons, others, has_rivals=has_rivals)) for one in several]
        told = [(one, whole.belief, whole.log_likelihood) for one, _, whole in rounds]
        _, by_beacons, best = max(rounds, key=lambda each: math.log(each[0].weight) + each[2].log_likelihood)
        self._hypotheses = reweighed(told)
        self.accepted += best.accepted
        self.rejected += best.rejected
        total = best.accepted + best.rejected
        if total >= MIN_BEACONS and best.rejected > DOUBT_SHARE * total:
            if self._is_lost_after_one_more():
                self._widen()
        elif best.accepted:
            self._doubts = 0
        return by_beacons >= MIN_BEACONS

    def _fused(
        self, belief: SplitBelief, beacons: RangeObservations, others: RangeObservations, *, has_rivals: bool
    ) -> tuple[int, Fusion]:
        """Return the number of beacons that were believed, and what became of all ranges together."""
        first = fuse_beacons(belief, beacons, self._ranges, has_rivals=has_rivals)
        then = fuse_neighbors(first.belief, others, self._ranges, has_rivals=has_rivals)
        return first.accepted, Fusion(
            then.belief,
            first.accepted + then.accepted,
            first.rejected + then.rejected,
            first.log_likelihood + then.log_likelihood,
        )

    def _take_trilateration(self, beacons: RangeObservations) -> bool:
        """Correct by a fix computed from ranges to beacons, if they determine one; return whether it was accepted."""
        # The literal mode takes the noise of the thesis, eq. (3.44): that of a position whose ranges fit exactly,
        # whatever the geometry of the beacons.
        is_literal = self._config.mode is LpsMode.LITERAL
        where, covariance = self._prior(beacons)
        range_sigma = 0.0 if is_literal else self._config.range_sigma
        found = trilaterate(beacons.positions, beacons.ranges, where, covariance, range_sigma)
        if not isinstance(found, Trilateration):
            return False
        if is_literal:
            return self._take_fix(found.position, self._config.position_noise_sigma**2 * _UNIT_NOISE)
        # The geometry at the propagated position, where there is one. At the fix itself it errs with the fix: among
        # beacons that are nearly on a line, the worst fixes would claim to be the best.
        noise = dilution(beacons.positions, where) if self._hypotheses else None
        covariance = found.covariance if noise is None else range_sigma**2 * noise
        return self._take_fix(found.position, covariance)

    def _prior(self, beacons: RangeObservations) -> tuple[FloatArray, FloatArray]:
        if self._hypotheses:
            gaussian = merged(self._hypotheses).gaussian
            return gaussian.mean[POSITION], gaussian.covariance[POSITION, POSITION]
        return (beacons.positions.mean(axis=0) if len(beacons) else np.zeros(2)), _NO_IDEA

    def _take_fix(self, position: FloatArray, noise: FloatArray) -> bool:
        """Correct by a measured position and its covariance; return whether it was accepted."""
        config = self._config
        if not self._hypotheses:
            self._begin(position, noise, config.initial_speed_sigma_mps)
            self.accepted += 1
            return True
        belief = merged(self._hypotheses)
        surprise = innovation(belief.gaussian, position - belief.gaussian.mean[POSITION], OBSERVE_POSITION, noise)
        if surprise.squared <= config.gate_chi_square:
            self._doubts = 0
            self.accepted += 1
            self._hypotheses = certain(fixed(belief, correct(belief.gaussian, surprise, OBSERVE_POSITION, noise)))
            return True
        self.rejected += 1
        if self._is_lost_after_one_more():
            start = restarted(belief.gaussian, config.restart_speed_sigma_mps, position, noise)
            self._hypotheses = certain(SplitBelief(start, 0.0))
        return False

    def _is_lost_after_one_more(self) -> bool:
        """Count one more round that did not fit; return whether the filter must restart.

        One wild fix is the sensor's fault. Several in a row mean that the robot was pushed, or had a bad start.
        """
        self._doubts += 1
        if self._doubts < self._config.rejections_max or not self._hypotheses:
            return False
        self._doubts = 0
        _log.warning("filter restarts: %d localizations in a row fell outside its gate", self._config.rejections_max)
        return True

    def _widen(self) -> None:
        """Restart without a fix: the robot may be elsewhere by meters, and what moved it may have changed its speed."""
        config, belief = self._config, merged(self._hypotheses)
        noise = np.zeros_like(belief.gaussian.covariance)
        noise[POSITION, POSITION] = config.restart_sigma_m**2 * _UNIT_NOISE
        noise[VELOCITY, VELOCITY] = config.restart_speed_sigma_mps**2 * _UNIT_NOISE
        # What is added is the robot's own error; what it shared before, it still shares.
        wider = Gaussian(belief.gaussian.mean, belief.gaussian.covariance + noise)
        self._hypotheses = certain(predicted(belief, wider, noise))

    def _begin_among(self, beacons: RangeObservations, others: RangeObservations) -> None:
        """Begin from neighbors that know where they are, if that can be; if not, wait."""
        found = begin_among(beacons, others, self._config.range_sigma)
        if found is not None:
            self._begin(*found, self._config.initial_speed_sigma_mps)

    def _begin(self, position: FloatArray, covariance: FloatArray, speed_sigma: float) -> None:
        bias = self._config.acceleration_bias_max_mps2
        self._hypotheses = certain(SplitBelief(belief_at(position, covariance, speed_sigma, bias), 0.0))


def _is_sound(imu: ImuSample) -> bool:
    """Return whether a sample can be true, with a heading: finite, and no more than a robot survives."""
    forward, left = imu.acceleration_body.tolist()
    is_possible = abs(forward) <= ACCELERATION_MAX_MPS2 and abs(left) <= ACCELERATION_MAX_MPS2
    return is_possible and imu.yaw is not None and abs(imu.yaw) <= YAW_MAX_RAD  # false for what is no number
