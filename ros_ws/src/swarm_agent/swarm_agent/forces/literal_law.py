"""The artificial forces of the thesis (section 3.2.1): shape, members and obstacles, as its equations have them.

The sums over resampled contours are integrals here (spec E2): every sum carries ds, attraction and transition are
divided by the length of the contour. Known limits of the law are part of it: it waits behind walls and in bays, and
where the boundary center lies outside the shape, so does the point at which its outer forces vanish.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from swarm_agent.forces.config import LiteralForceConfig
from swarm_agent.forces.force_law import Offsets, Others
from swarm_agent.forces.obstacle_integral import ObstacleIntegral
from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals, IntegralsAt
from swarm_msgs_py.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Forces:
    """The five forces, (n, 2) each.

    Attributes
    ----------
    attractive, transition : (n, 2) array
        To the boundary center and to the contour, outside (thesis eqs. (3.80), (3.89)).
    repulsive : (n, 2) array
        Away from the contour, inside (3.83).
    intermember : (n, 2) array
        Away from other robots (3.86).
    obstacle : (n, 2) array
        Away from obstacles (3.92).
    """

    attractive: FloatArray
    transition: FloatArray
    repulsive: FloatArray
    intermember: FloatArray
    obstacle: FloatArray

    @property
    def total(self) -> FloatArray:
        """Their sum (3.79), with the obstacle force that is missing there (spec E4)."""
        total: FloatArray = self.attractive + self.transition + self.repulsive + self.intermember + self.obstacle
        return total


class LiteralLaw:
    """The thesis' forces among one contour and its obstacles.

    Parameters
    ----------
    config : LiteralForceConfig
    contour : (k, 2) array
        Desired shape, simple and counter-clockwise [m].
    obstacles : sequence of (m, 2) array
        Outlines [m].
    step_max : float
        Longest time over which one evaluation may move a robot [s]. The stiffness 2 k_m / gap^3 asks for 0.1 s.
    """

    def __init__(
        self, config: LiteralForceConfig, contour: FloatArray, obstacles: Sequence[FloatArray], step_max: float
    ) -> None:
        self._config = config
        self._contour = ContourIntegrals(contour)
        self._obstacles = ObstacleIntegral(obstacles, config.obstacle_gap_min_m)
        self._step_max = step_max

    @property
    def step_max(self) -> float:
        """Longest time over which a robot may be moved by one evaluation [s]."""
        return self._step_max

    def evaluate(self, positions: FloatArray, radii: FloatArray, others: Others) -> FloatArray:
        """Return the total force on each robot, (n, 2); see `ForceLaw`."""
        return self.forces(positions, radii, others).total

    def forces(self, positions: FloatArray, radii: FloatArray, others: Others) -> Forces:
        """Return the five forces on each robot; parameters as for `evaluate`."""
        config = self._config
        at = self._contour.at(positions)
        depths = at.signed_distances[:, None] / config.buffer_m
        inner = np.minimum(np.maximum(depths, 0.0), 1.0)  # lambda of spec 8.3
        outer = (1.0 - inner) / self._contour.length
        offsets = Offsets(positions, radii, others)
        gaps = np.maximum(offsets.gaps, config.robot_gap_min_m)
        return Forces(
            attractive=config.attractive_gain * outer * at.attraction,
            transition=_blended(config.transition_gain * outer, at, _TRANSITION),
            repulsive=_blended(config.repulsive_gain * inner, at, _REPULSION),
            intermember=offsets.push(config.intermember_gain / (gaps * gaps)),
            obstacle=config.obstacle_gain * self._obstacles.at(positions, radii),
        )


_TRANSITION, _REPULSION = attrgetter("transition"), attrgetter("repulsion")


def _blended(weights: FloatArray, at: IntegralsAt, integral: Callable[[IntegralsAt], FloatArray]) -> FloatArray:
    """Return an integral times its (n, 1) weights, (n, 2), computed only where these are not 0."""
    count = np.count_nonzero(weights)
    if count == len(weights):
        return weights * integral(at)
    blended = np.zeros((len(weights), 2))
    if count:
        rows = weights[:, 0].nonzero()[0]
        blended[rows] = weights[rows] * integral(at.only(rows))
    return blended
