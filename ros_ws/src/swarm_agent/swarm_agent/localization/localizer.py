"""A robot's own position and velocity: dead reckoning at every tick, corrected by position fixes."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass

import numpy as np

from swarm_agent.localization.config import LpsConfig
from swarm_agent.localization.kalman import Gaussian, correct, innovation, predict
from swarm_agent.localization.motion_model import OBSERVE_POSITION, POSITION, VELOCITY, MotionModel, belief_at
from swarm_msgs_py.messages.sensing import ImuSample, PositionFix
from swarm_msgs_py.types import FloatArray

MIN_SIGMA = 1e-4  # no position sensor is better [m]; keeps the filter regular when noise is switched off

_log = logging.getLogger(__name__)
_UNIT_NOISE: FloatArray = np.eye(2)


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
    """

    position: FloatArray
    velocity: FloatArray
    covariance: FloatArray
    yaw: float


class Localizer:
    """Kalman filter of one robot (thesis eqs. (3.28)-(3.44)).

    Parameters
    ----------
    config : LpsConfig
    period_s : float
        Control period [s].
    """

    def __init__(self, config: LpsConfig, period_s: float) -> None:
        self._config = config
        self._model = MotionModel(
            period_s,
            config.acceleration_sigma_mps2,
            config.yaw_sigma_rad,
            config.push_delay_s,
            config.push_delay_sigma_s,
        )
        self._belief: Gaussian | None = None
        self._rejections = 0

    def step(self, imu: ImuSample, fix: PositionFix | None) -> Estimate | None:
        """Advance by one tick.

        Parameters
        ----------
        imu : ImuSample
            Over the tick that ends now.
        fix : PositionFix or None
            Taken now. A fix that is not finite counts as none.

        Returns
        -------
        Estimate or None
            None until the first fix.
        """
        if self._belief is not None:
            step = self._model.step(imu.acceleration_body, imu.yaw)
            self._belief = predict(self._belief, step.transition, step.drive, step.noise)
        if fix is not None and math.isfinite(fix.sigma + sum(fix.position.tolist())):
            self._belief = self._corrected(fix.position, max(fix.sigma, MIN_SIGMA))
        belief = self._belief
        if belief is None:
            return None
        covariance = belief.covariance[POSITION, POSITION].copy()
        return Estimate(belief.mean[POSITION].copy(), belief.mean[VELOCITY].copy(), covariance, imu.yaw)

    def _corrected(self, position: FloatArray, sigma: float) -> Gaussian:
        """Return the belief after a fix: corrected, unchanged (outlier) or made anew (lost)."""
        belief, config = self._belief, self._config
        if belief is None:
            return belief_at(position, sigma, config.initial_speed_sigma_mps, config.acceleration_bias_max_mps2)
        noise = sigma**2 * _UNIT_NOISE
        surprise = innovation(belief, position - belief.mean[POSITION], OBSERVE_POSITION, noise)
        if surprise.squared <= config.gate_chi_square:
            self._rejections = 0
            return correct(belief, surprise, OBSERVE_POSITION, noise)
        self._rejections += 1
        if self._rejections < config.rejections_max:
            return belief
        # One wild fix is the sensor's fault. Several in a row mean that the filter is lost (pushed, or a bad start).
        self._rejections = 0
        _log.warning("filter restarts: %d fixes in a row fell outside its gate", config.rejections_max)
        return belief_at(position, sigma, config.restart_speed_sigma_mps, config.acceleration_bias_max_mps2)
