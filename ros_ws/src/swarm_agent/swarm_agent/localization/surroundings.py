"""What stands around a robot, and what that says of the robot's own place.

Walls of the map are landmarks (`walls`). Robots are none, but they explain what is seen: those that were heard lately,
those that fell silent at rest and still stand there, and the bodies that the mission computer knows of.

What neither explains speaks against the robot's belief. One that thinks to be past a wall's end, and is not, stands
before it with an estimate that no wall within three standard deviations fits. So such a robot *doubts*: its belief
widens, until some wall fits. That is a remedy for robots that get nowhere, and for nobody else: who is parked
beside something unknown, or drives past it, has no reason to believe that it is the robot itself who errs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from swarm_agent.localization.config import LpsConfig
from swarm_agent.localization.hypotheses import Hypotheses, Hypothesis, merged, reweighed, widest
from swarm_agent.localization.kalman import Gaussian
from swarm_agent.localization.motion_model import OBSERVE_POSITION, POSITION
from swarm_agent.localization.observations import VAGUE_M, bodies, strangers
from swarm_agent.localization.range_fusion import SplitBelief, fuse_walls, predicted
from swarm_agent.localization.walls import FIT_M, ROBOT_M, SIGMAS, WallMap, are_no_robots
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.messages.sensing import RangeScan
from swarm_msgs_py.types import BoolArray, FloatArray, NodeId

MOVING_MPS = 0.1
"""Who was this fast when last heard is elsewhere by now [m/s]."""

PASSING_S, STAYING_S = 5.0, 20.0
"""So long does a robot that fell silent, moving or at rest, keep others from taking it for a wall [s]."""

_NO_POINTS: FloatArray = np.empty((0, 2))


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What became of a belief at a look around.

    Attributes
    ----------
    hypotheses : Hypotheses
    faces : (f, 2) array
        The sensed points that were recognized as walls [m].
    """

    hypotheses: Hypotheses
    faces: FloatArray


class Surroundings:
    """Walls, robots and bodies around one robot.

    Parameters
    ----------
    config : LpsConfig
        With a `wall_sigma_m`.
    period_s : float
        Control period [s].
    walls : sequence of (k, 2) array
        Obstacles whose place is certain [m]; if there is none, those of the plan count.
    """

    def __init__(self, config: LpsConfig, period_s: float, walls: Sequence[FloatArray]) -> None:
        assert config.wall_sigma_m is not None
        self._config, self._period = config, period_s
        self._sigma = config.wall_sigma_m
        self._map, self._has_own_map = WallMap(walls), len(walls) > 0
        self._bodies = shapely.MultiPolygon()
        self._delay = round(config.walls_after_s / period_s)
        self._from: int | None = None  # tick of the first look
        self._doubt_after = round(config.doubt_after_s / period_s)
        self._unexplained = 0  # ticks in a row with something near that is neither wall nor robot nor body
        self._heard: dict[NodeId, Presence] = {}  # last words: a body stays where its radio fell silent
        self._resting: dict[NodeId, Presence] = {}  # last words, not lately, of robots that stood still

    def learn(self, walls: Sequence[FloatArray], bodies: Sequence[FloatArray]) -> None:
        """Take note of what a plan says.

        Parameters
        ----------
        walls : sequence of (k, 2) array
            Obstacles of the map [m].
        bodies : sequence of (k, 2) array
            Where lost robots may stand, as far as that is known [m]. They explain what is seen; landmarks they are not.
        """
        if not self._has_own_map:
            self._map = WallMap(walls)
        self._bodies = shapely.union_all([shapely.convex_hull(shapely.multipoints(body)) for body in bodies])

    def hear(self, tick: int, neighbors: Mapping[NodeId, Presence]) -> None:
        """Note the latest words of the radio neighbors; to be called in every tick."""
        if self._from is None:
            self._from = tick + self._delay
        self._heard.update(neighbors)
        for robot in self._resting.keys() & neighbors.keys():
            del self._resting[robot]

    def look(  # noqa: PLR0913 - what there is to compare
        self,
        tick: int,
        hypotheses: Hypotheses,
        points: FloatArray,
        scan: RangeScan,
        neighbors: Mapping[NodeId, Presence],
        *,
        is_blocked: bool,
    ) -> Look:
        """Correct a belief by what is seen.

        Parameters
        ----------
        tick : int
        hypotheses : Hypotheses
            At least one.
        points : (k, 2) array
            Nearest points of what is near, relative to the robot, axes of the world [m].
        scan, neighbors
            Ranges and words of the radio neighbors of this tick.
        is_blocked : bool
            The robot wants to drive, and has hardly got on for some time.
        """
        if not len(points) or self._from is None or tick < self._from:
            self._unexplained = 0
            return Look(hypotheses, _NO_POINTS)
        places, unsure = bodies(self._near_by_last_word(tick))
        is_vague = unsure >= VAGUE_M
        if is_vague.any():
            places, unsure = places[~is_vague], unsure[~is_vague]
            points = points[_are_no_strangers(points, strangers(scan, neighbors), self._config.range_sigma)]
        gate = self._config.range_gate_chi_square
        told, faces = [], _NO_POINTS
        likeliest = max(hypotheses, key=lambda one: one.weight)
        for one in hypotheses:
            gaussian = one.belief.gaussian
            mean, covariance = gaussian.mean[POSITION], gaussian.covariance[POSITION, POSITION]
            seen = self._map.recognize(mean, covariance, points, places, unsure)
            after = one.belief
            if len(seen.offsets):
                after = fuse_walls(after, seen.directions, seen.offsets, self._sigma, gate)
            told.append((one, after, seen.log_likelihood))
            if one is likeliest:
                faces = seen.faces
                is_explained = self._is_explained(mean + seen.unexplained, widest(covariance))
                self._unexplained = 0 if is_explained else self._unexplained + 1
        after_look = reweighed(told)
        if is_blocked and self._unexplained > self._doubt_after:
            after_look = self._doubtful(after_look)
        return Look(after_look, faces)

    def _near_by_last_word(self, tick: int) -> list[Presence]:
        """Return the last words of those that may still stand where they said, and hide a wall.

        Who falls silent has died there, or has driven on, out of sight behind a wall. That wall must not stay hidden
        for good because somebody once passed it. But who stood still explains what is seen there as long as it
        is not heard from elsewhere.
        """
        for robot, presence in list(self._heard.items()):
            age = ((tick - presence.tick) & 0xFFFF) * self._period
            if age <= PASSING_S:
                continue
            is_moving = float(np.abs(presence.velocity).max()) > MOVING_MPS
            if is_moving or age > STAYING_S:
                del self._heard[robot]
                if not is_moving and presence.sigma < VAGUE_M:
                    self._resting[robot] = presence
        return list(self._heard.values())

    def _is_explained(self, spots: FloatArray, sigma: float) -> bool:
        """Return whether bodies may be at all the places, (u, 2), for a robot that is so unsure of its own [m]."""
        if len(spots) and self._resting:
            spots = spots[are_no_robots(spots, sigma, *bodies(self._resting.values()))]
        if not len(spots):
            return True
        distances = shapely.distance(self._bodies, shapely.points(spots))  # not a number if there is no body
        return bool((distances <= FIT_M + SIGMAS * sigma).all())

    def _doubtful(self, hypotheses: Hypotheses) -> Hypotheses:
        """Return a belief whose position is less certain, for reasons of its own, but not beyond the bound."""
        now = widest(merged(hypotheses).gaussian.covariance[POSITION, POSITION])
        room = self._config.doubt_sigma_max_m**2 - now**2
        if room <= 0.0:
            return hypotheses
        added = min(self._config.doubt_m2_per_s * self._period, room)
        return tuple(Hypothesis(one.weight, _widened(one.belief, added)) for one in hypotheses)


def _widened(belief: SplitBelief, variance: float) -> SplitBelief:
    noise = variance * (OBSERVE_POSITION.T @ OBSERVE_POSITION)
    return predicted(belief, Gaussian(belief.gaussian.mean, belief.gaussian.covariance + noise), noise)


def _are_no_strangers(points: FloatArray, ranges: FloatArray, range_sigma: float) -> BoolArray:
    """Return which points, (k, 2), are nearer or farther than any of the robots that do not know where they are.

    Such a robot may be anywhere, for all that it says. How far it is, a range tells.
    """
    off = np.abs(np.hypot(*points.T)[:, None] - ranges)
    return np.asarray((off > ROBOT_M + SIGMAS * range_sigma).all(axis=1))
