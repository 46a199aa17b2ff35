"""Is the robot localized, lost, or on its way home to be localized again? (thesis section 3.1.3, erratum E27)."""

from __future__ import annotations

import logging
from dataclasses import dataclass

from swarm_agent.localization.config import LostRule, LpsConfig
from swarm_msgs_py.messages.report import Positioning

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Signs:
    """What the state follows from, as of one tick.

    Attributes
    ----------
    beacons : int
        Beacons that are direct radio neighbors.
    has_fix : bool
        The robot's own position sensor works: a beacon is never lost.
    accepted : bool
        A fix, or enough ranges, corrected the estimate in this tick.
    sigma : float
        Standard deviation of the position in the direction where it is largest [m].
    """

    beacons: int
    has_fix: bool
    accepted: bool
    sigma: float


class PositioningMonitor:
    """State machine of one robot, reviewed at fixed intervals (spec section 6).

    ===========  ======================================  =========================================================
    state        entered                                 left
    ===========  ======================================  =========================================================
    localized    good review                             bad review: lost
    lost         bad review                              good review: localized; `misses_max` bad ones in a row:
                                                         return home
    return home  `misses_max` bad reviews in a row       `returns_min` good reviews in a row: localized
    ===========  ======================================  =========================================================

    A review is good, by the thesis' rule, if at least `beacons_min` beacons are direct neighbors and a fix was accepted
    since the last review; by the other rule if the position's standard deviation is at most `sigma_max_m`. Both are
    reported; `LostConfig.rule` says which one acts. A robot with a position sensor is never lost while that works.

    Parameters
    ----------
    config : LpsConfig
        Its section `lost` is meant. Reviews are not more frequent than localizations, or some would have none to judge.
    period_s : float
        Control period [s].
    """

    def __init__(self, config: LpsConfig, period_s: float) -> None:
        self._config = config.lost
        self._rule = config.lost_rule
        self._every = max(1, round(max(config.lost.review_period_s, config.period_s) / period_s))
        self._accepted_since_review = self._fixed_since_review = False
        self._bad, self._good = 0, 0
        self.state = Positioning.LOCALIZED
        self.lost_by_beacons = self.lost_by_sigma = False
        """What each rule said at the last review."""

    def step(self, tick: int, signs: Signs) -> Positioning:
        """Return the state after one tick."""
        self._accepted_since_review |= signs.accepted
        self._fixed_since_review |= signs.has_fix
        if tick % self._every == 0 and tick > 0:
            self._review(signs)
            self._accepted_since_review = self._fixed_since_review = False
        return self.state

    def _review(self, signs: Signs) -> None:
        config = self._config
        is_beacon = self._fixed_since_review
        heard_enough = signs.beacons >= config.beacons_min and self._accepted_since_review
        self.lost_by_beacons = not (is_beacon or heard_enough)
        self.lost_by_sigma = not (is_beacon or signs.sigma <= config.sigma_max_m)
        is_good = not (self.lost_by_sigma if self._rule is LostRule.SIGMA else self.lost_by_beacons)
        self._bad, self._good = (0, self._good + 1) if is_good else (self._bad + 1, 0)
        before = self.state
        if self.state is Positioning.RETURN_HOME:
            if self._good >= config.returns_min:
                self.state = Positioning.LOCALIZED
        elif is_good:
            self.state = Positioning.LOCALIZED
        else:
            self.state = Positioning.RETURN_HOME if self._bad >= config.misses_max else Positioning.LOST
        if self.state is not before:
            _log.info(
                "positioning: %s to %s (%d beacons, sigma %.2f m)",
                before.name, self.state.name, signs.beacons, signs.sigma,
            )  # fmt: skip
