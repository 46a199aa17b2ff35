"""A robot's own position and velocity: dead reckoning at every tick, corrected by fixes and ranges."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_agent.localization.config import LpsConfig, LpsMode
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
)
from swarm_agent.localization.observations import RangeObservations, bodies, observe
from swarm_agent.localization.range_fusion import (
    Fusion,
    RangeModel,
    SplitBelief,
    fixed,
    fuse_beacons,
    fuse_neighbors,
    fuse_walls,
    predicted,
)
from swarm_agent.localization.trilateration import MIN_BEACONS, Trilateration, dilution, trilaterate
from swarm_agent.localization.walls import WallMap
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix, RangeScan
from swarm_msgs_py.types import FloatArray, NodeId

MIN_SIGMA = 1e-4  # no position sensor is better [m]; keeps the filter regular when noise is switched off
BEACON_MEMORY_S = 3.0  # a sensor that has said nothing usable for that long makes no beacon any more
WALLS_AFTER = 6  # ticks, from the first on, in which what is near may be a robot that has not been heard yet
MOVING_MPS = 0.1  # who was this fast when last heard is elsewhere by now
PASSING_S, STAYING_S = 5.0, 20.0  # so long does a silent robot keep others from taking it for a wall
UNEXPLAINED_TICKS = 10  # so long may a robot that was never heard be what stands in the way
DOUBT_M2 = 0.05  # by so much per tick, and axis, a belief widens that does not explain what is seen [m^2]
DOUBT_SHARE = 0.5  # a round in which more than this share of the ranges are outliers speaks against the filter

_log = logging.getLogger(__name__)
_UNIT_NOISE: FloatArray = np.eye(2)
_NO_IDEA: FloatArray = np.diag([math.inf, math.inf])
_DOUBT_NOISE: FloatArray = DOUBT_M2 * (OBSERVE_POSITION.T @ OBSERVE_POSITION)
_NO_POINTS: FloatArray = np.empty((0, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """What a robot knows of its own motion.

    Attributes
    ----------
    position, velocity : (2,) array
        World frame [m], [m/s].
    covariance : (2, 2) array
        Of the position [m^2].
    yaw : float
        Heading [rad].
    shared : float
        Share of the position's variance that the neighbors' errors have in common with it, 0 to 1.
    is_corrected : bool
        A fix, or ranges to at least three beacons, were accepted in this tick.
    """

    position: FloatArray
    velocity: FloatArray
    covariance: FloatArray
    yaw: float
    shared: float = 0.0
    is_corrected: bool = False


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
        Obstacles whose place is certain [m].
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
        self._ranges = RangeModel(config.range_sigma_m, config.range_gate_chi_square, config.covariance_inflation)
        self._hypotheses: Hypotheses = ()  # none: the position is unknown
        if start is not None:
            self._begin(start.position, start.sigma**2 * _UNIT_NOISE, config.initial_speed_sigma_mps)
        is_literal = config.mode is LpsMode.LITERAL
        self._command_sigma = None if is_literal else config.command_sigma_mps
        self._lag = math.exp(-period_s / config.push_delay_s) if config.push_delay_s > 0.0 else 0.0
        self._told_before: FloatArray | None = None
        self._walls = None if is_literal or config.wall_sigma_m is None else WallMap(walls)
        self._walls_from: int | None = None  # tick
        self._unexplained = 0  # ticks in a row with something near that is no wall and no robot
        self._heard: dict[NodeId, Presence] = {}  # last words: a body stays where its radio fell silent
        self._due = 0  # tick of the next localization
        self._doubts = 0  # fixes, or rounds of ranging, in a row that did not fit
        self._beacon_until = -1  # tick
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
    ) -> Estimate | None:
        """Advance by one tick.

        Parameters
        ----------
        tick : int
        imu : ImuSample
            Over the tick that ends now.
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

        Returns
        -------
        Estimate or None
            None as long as the position is unknown.
        """
        if self._hypotheses:
            step = self._model.step(imu.acceleration_body, imu.yaw)
            noise = self._command_noise(told)
            self._change(lambda belief: self._moved(belief, step, told, noise))
        self._told_before = told
        is_corrected = False
        if fix is not None and math.isfinite(fix.sigma + sum(fix.position.tolist())):
            is_corrected = self._take_fix(fix.position, max(fix.sigma, MIN_SIGMA) ** 2 * _UNIT_NOISE)
            if is_corrected:
                self._beacon_until = tick + round(BEACON_MEMORY_S / self._period)
        elif len(scan.neighbors) and tick >= self._due:
            self._due = tick + self._every
            is_corrected = self._take_ranges(*observe(scan, neighbors, tick, self._period))
        self.walls = _NO_POINTS
        self._heard.update(neighbors)
        self._walls_from = tick + WALLS_AFTER if self._walls_from is None else self._walls_from
        if len(proximity) and self._walls is not None and self._hypotheses and tick >= self._walls_from:
            self._take_walls(self._walls, proximity, tick)
        else:
            self._unexplained = 0
        self.is_beacon = tick <= self._beacon_until
        return self._estimate(imu.yaw, is_corrected=is_corrected)

    def _estimate(self, yaw: float, *, is_corrected: bool) -> Estimate | None:
        if not self._hypotheses:
            return None
        belief = merged(self._hypotheses)
        mean, covariance = belief.gaussian.mean, belief.gaussian.covariance[POSITION, POSITION].copy()
        return Estimate(mean[POSITION].copy(), mean[VELOCITY].copy(), covariance, yaw, belief.shared, is_corrected)

    def _change(self, changed: Callable[[SplitBelief], SplitBelief]) -> None:
        """Apply to every hypothesis what tells nothing of which one is right."""
        self._hypotheses = tuple(Hypothesis(one.weight, changed(one.belief)) for one in self._hypotheses)

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
        behind = self._lag * float(np.hypot(*(told - self._told_before)))
        return (self._command_sigma + behind) ** 2 * _UNIT_NOISE

    def _near_by_last_word(self, tick: int) -> list[Presence]:
        """Return the last words of those that may still stand where they said; forget the others.

        Who falls silent has died there, or has driven on, out of sight behind a wall. That wall must not stay hidden
        for good because somebody once passed it.
        """
        for robot, presence in list(self._heard.items()):
            age = ((tick - presence.tick) & 0xFFFF) * self._period
            is_moving = float(np.abs(presence.velocity).max()) > MOVING_MPS
            if age > (PASSING_S if is_moving else STAYING_S):
                del self._heard[robot]
        return list(self._heard.values())

    def _take_walls(self, walls: WallMap, points: FloatArray, tick: int) -> None:
        """Correct by the walls of the map that the sensed points belong to."""
        sigma, gate = self._config.wall_sigma_m, self._config.range_gate_chi_square
        assert sigma is not None  # or there would be no map
        places, unsure = bodies(self._near_by_last_word(tick))
        told = []
        likeliest = max(self._hypotheses, key=lambda one: one.weight, default=None)
        for one in self._hypotheses:
            gaussian = one.belief.gaussian
            seen = walls.recognize(
                gaussian.mean[POSITION], gaussian.covariance[POSITION, POSITION], points, places, unsure
            )
            after = (
                fuse_walls(one.belief, seen.directions, seen.offsets, sigma, gate) if len(seen.offsets) else one.belief
            )
            told.append((one, after, seen.log_likelihood))
            if one is likeliest:
                self.walls = seen.faces
                self._unexplained = 0 if seen.is_explained else self._unexplained + 1
        self._hypotheses = reweighed(told)
        if self._unexplained > UNEXPLAINED_TICKS:
            # Something stands where nothing should: little by little, the robot believes it rather than itself.
            self._change(_doubtful)

    def _take_ranges(self, beacons: RangeObservations, others: RangeObservations) -> bool:
        """Correct by ranges; return whether the beacons determined the position."""
        if not self._hypotheses or self._config.mode in (LpsMode.LITERAL, LpsMode.FIXES):
            return self._take_trilateration(beacons)
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
            self._doubt()
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
        range_sigma = 0.0 if is_literal else self._config.range_sigma_m
        found = trilaterate(beacons.positions, beacons.ranges, where, covariance, range_sigma)
        if not isinstance(found, Trilateration):
            return False
        if is_literal:
            return self._take_fix(found.position, self._config.position_noise_sigma_m**2 * _UNIT_NOISE)
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
        if self._doubt():
            self._begin(position, noise, config.restart_speed_sigma_mps)
        return False

    def _doubt(self) -> bool:
        """Count one more round that did not fit; return whether the filter has been lost, and forgets where it is.

        One wild fix is the sensor's fault. Several in a row mean that the robot was pushed, or had a bad start.
        """
        self._doubts += 1
        if self._doubts < self._config.rejections_max or not self._hypotheses:
            return False
        self._doubts = 0
        _log.warning("filter restarts: %d localizations in a row fell outside its gate", self._config.rejections_max)
        belief = merged(self._hypotheses)
        narrow = belief.gaussian.covariance[POSITION, POSITION]
        wider = narrow + self._config.restart_sigma_m**2 * _UNIT_NOISE
        # What is added is the robot's own error; what it shared before, it still shares.
        shared = belief.shared * float(narrow.trace() / wider.trace())
        self._begin(belief.gaussian.mean[POSITION], wider, self._config.restart_speed_sigma_mps, shared)
        return True

    def _begin(self, position: FloatArray, covariance: FloatArray, speed_sigma: float, shared: float = 0.0) -> None:
        bias = self._config.acceleration_bias_max_mps2
        self._hypotheses = certain(SplitBelief(belief_at(position, covariance, speed_sigma, bias), shared))


def _doubtful(belief: SplitBelief) -> SplitBelief:
    """Return a belief whose position is less certain, for reasons of its own."""
    covariance = belief.gaussian.covariance.copy()
    covariance[POSITION, POSITION] += DOUBT_M2 * _UNIT_NOISE
    return predicted(belief, Gaussian(belief.gaussian.mean, covariance), _DOUBT_NOISE)
