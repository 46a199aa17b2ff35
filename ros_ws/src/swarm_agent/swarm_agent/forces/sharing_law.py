"""The own variant of the artificial forces: to the middle of one's share of the shape, along the shortest free path.

It knows what the thesis' law knows: contour, obstacles, the own place, the places that others tell by radio. It
differs in what attracts. Outside, that is the point of the inset contour to which the shortest path leads, not a
center that may lie outside or behind a wall. Inside, it is the robot's own share (`Shares`), out of which no crowd
elsewhere can push it. The intermember force ends at a short free gap: what keeps robots evenly apart is the shares.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from swarm_agent.forces.config import ForceConfig
from swarm_agent.forces.force_law import Offsets, Others
from swarm_agent.forces.ground import Ground
from swarm_agent.forces.shares import Claim, Shares
from swarm_agent.planning.config import PlanningConfig
from swarm_agent.planning.path_planner import planner_for
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.types import FloatArray

_TINY = 1e-12  # [m]
_SPACING = 1.0746  # sqrt(2 / sqrt(3)): distance of neighbors in a hexagonal mesh, in square roots of the area of a cell
_RANGE_MIN = 0.02  # [m]; where there is no room between robots, the force is one of contact


class SharingLaw:
    """Forces toward a place in the shape that nobody else has.

    Parameters
    ----------
    config : ForceConfig
    contour : (k, 2) array
        Desired shape, simple and counter-clockwise [m].
    obstacles : sequence of (m, 2) array
        Outlines [m].
    planning : PlanningConfig
        How far paths keep from obstacles.
    """

    def __init__(
        self, config: ForceConfig, contour: FloatArray, obstacles: Sequence[FloatArray], planning: PlanningConfig
    ) -> None:
        self._config = config
        self._contour = contour
        self._obstacles = tuple(obstacles)
        self._planning = planning
        self._shares = Shares(config.sharing, contour)
        self._grounds: dict[float, Ground] = {}

    @property
    def step_max(self) -> float:
        """Longest time over which a robot may be moved by one evaluation [s]: that covers half of its way."""
        return 0.5 / self._config.sharing.gain_1_s

    def evaluate(self, positions: FloatArray, radii: FloatArray, others: Others) -> FloatArray:
        """Return the force on each robot, (n, 2); see `ForceLaw`."""
        claims = [
            self._shares.claim(position, others.positions[heard])
            for position, heard in zip(positions, others.heard, strict=True)
        ]
        pulls = np.array(
            [
                self._pull(position, float(radius), claim)
                for position, radius, claim in zip(positions, radii, claims, strict=True)
            ]
        )
        areas = np.array([np.inf if claim is None else claim.area for claim in claims])
        return pulls + self._push(positions, radii, others, areas)

    def _push(self, positions: FloatArray, radii: FloatArray, others: Others, areas: FloatArray) -> FloatArray:
        """Return the intermember forces, (n, 2).

        Parameters
        ----------
        positions, radii, others
            As for `evaluate`.
        areas : (n,) array
            Of the robots' shares, inf for those without one [m^2]. Where these are small the force is short, so that
            robots in the middle of their shares do not push each other.
        """
        config = self._config.sharing
        offsets = Offsets(positions, radii, others)
        if not np.count_nonzero(offsets.gaps < config.personal_gap_m):  # no range is longer
            return np.zeros_like(positions)
        even_gaps = (_SPACING * np.sqrt(areas) - radii)[:, None] - others.radii
        # Not np.clip: on so few numbers its checks cost more than its work.
        ranges = np.minimum(np.maximum(config.personal_share * even_gaps, _RANGE_MIN), config.personal_gap_m)
        nearness = np.minimum(np.maximum(1.0 - offsets.gaps / ranges, 0.0), 1.0)
        firm = config.firmness * self._config.f_sat
        push = offsets.push(firm * nearness * nearness)
        # However many push: an obstacle must be able to push back.
        push *= (firm / np.maximum(np.hypot(push[:, 0], push[:, 1]), firm))[:, None]
        return push

    def _pull(self, position: FloatArray, radius: float, claim: Claim | None) -> FloatArray:
        """Return what shape and obstacles do to one robot, (2,).

        The attraction is a force of full speed, except close to the end of the path. The obstacle force acts within the
        margin that paths keep, where only other robots can have pushed it.
        """
        config, ground = self._config, self._ground(radius)
        eye = ground.eye(position)
        way, is_last = ground.way(position, eye, None if claim is None else position + claim.way)
        distance = float(np.hypot(way[0], way[1]))
        speed = config.sharing.gain_1_s * distance if is_last else config.speed_max_m_s
        pull = way * (config.f_sat * min(speed / config.speed_max_m_s, 1.0) / max(distance, _TINY))
        if eye is position:  # free, as nearly always
            return pull
        return pull + 2.0 * config.sharing.firmness * config.f_sat * ground.trespass(position, eye)

    def _ground(self, radius: float) -> Ground:
        ground = self._grounds.get(radius)
        if ground is None:
            planner = planner_for(self._obstacles, radius, self._planning)
            inset = radius + self._config.sharing.inset * math.sqrt(signed_area(self._contour))
            margin = self._planning.clearance_margin_m
            ground = self._grounds[radius] = Ground(self._contour, inset, planner, margin)
        return ground
