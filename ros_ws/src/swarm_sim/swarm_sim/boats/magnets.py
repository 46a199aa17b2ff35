"""Docking mechanisms: which sides feel each other, how hard they pull, when they latch, what the contact foils say.

A side's magnet pulls on one that it joins, from a few centimeters on, and latches when the two sides are close and face
each other. Latched sides hold until more than the magnets' force tears them apart, or one of the magnets fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from swarm_msgs_py.assembly.faces import Face, Gender, Layout
from swarm_msgs_py.types import BoolArray, FloatArray, IntArray
from swarm_sim.boats.bodies import FACE_VECTORS, Latch
from swarm_sim.boats.config import CELL_M, MagnetConfig

MARGIN_M = 0.1
"""How much nearer two boats may come before `Magnets.look_around` is called again [m]."""
STEEPNESS = 4
"""Exponent of the fall of the pull with the gap."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Sides that may come to feel each other, one row per pair of sides."""

    boats: IntArray
    faces: IntArray
    others: IntArray
    other_faces: IntArray
    joins: BoolArray


class Magnets:
    """The mechanisms of all boats.

    Parameters
    ----------
    config : MagnetConfig
    layouts : sequence of Layout
        Of each boat, in its own frame: as at its start.
    gender : Gender

    Attributes
    ----------
    latches : list of Latch
        Pairs that hold, in the order in which they latched.
    """

    def __init__(self, config: MagnetConfig, layouts: Sequence[Layout], gender: Gender) -> None:
        self._config = config
        self._kinds = np.array(layouts, dtype=np.int64).reshape(-1, len(Face))
        self._joins = np.array([[gender.joins(one, other) for other in range(3)] for one in range(3)])
        self._tightest = np.cos(np.radians(config.latch_angle_deg))
        self.latches: list[Latch] = []
        self._pairs = self._pairs_of(np.zeros((0, 2), dtype=np.int64))

    @property
    def contacts(self) -> BoolArray:
        """Which contact foils are pressed (n, 4): those of latched sides."""
        pressed = np.zeros(self._kinds.shape, dtype=np.bool_)
        for one in self.latches:
            pressed[one.boat, one.face] = pressed[one.other, one.other_face] = True
        return pressed

    @property
    def is_docked(self) -> BoolArray:
        """Who is held by another boat (n,)."""
        return np.asarray(self.contacts.any(axis=1))

    def look_around(self, poses: FloatArray) -> None:
        """Find who is near whom; to be called before anybody moves by more than half of `MARGIN_M`."""
        reach = np.hypot(1.0, 1.0) * 0.5 * CELL_M * 2.0 + self._config.reach_m + MARGIN_M
        near = cKDTree(poses[:, :2]).query_pairs(reach, output_type="ndarray").astype(np.int64).reshape(-1, 2)
        self._pairs = self._pairs_of(near[np.lexsort((near[:, 1], near[:, 0]))])

    def wrenches(self, poses: FloatArray) -> FloatArray:
        """Return pull and push of sides that are near each other and not latched, world frame (n, 3) [N], [N m]."""
        total = np.zeros((len(self._kinds), 3))
        pairs = self._pairs
        if not len(pairs.boats):
            return total
        gaps, normals, opposed = self._geometry(poses)
        distance = np.linalg.norm(gaps, axis=1)
        feels = (distance < self._config.reach_m) & (opposed > 0.5)
        if not feels.any():
            return total
        strength = np.where(pairs.joins, self._config.force_n, -self._config.repulsion_n)
        strength = strength[feels] / (1.0 + distance[feels] / self._config.decay_m) ** STEEPNESS
        pull = strength[:, None] * gaps[feels] / np.maximum(distance[feels], 1e-9)[:, None]
        for rows, faces, force in (
            (pairs.boats[feels], normals[0][feels], pull),
            (pairs.others[feels], normals[1][feels], -pull),
        ):
            arms = 0.5 * CELL_M * faces
            moment = arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]
            np.add.at(total, rows, np.column_stack([force, moment]))
        return total

    def latch(self, poses: FloatArray) -> list[Latch]:
        """Latch what is close enough, and return it."""
        if not len(self._pairs.boats):
            return []
        gaps, _, opposed = self._geometry(poses)
        close = np.linalg.norm(gaps, axis=1) < self._config.latch_gap_m
        rows = np.flatnonzero(close & (opposed > self._tightest) & self._pairs.joins)
        pairs = self._pairs
        fresh = [
            Latch(int(pairs.boats[r]), int(pairs.others[r]), Face(pairs.faces[r]), Face(pairs.other_faces[r]))
            for r in rows.tolist()
        ]
        self.latches += fresh
        if fresh:
            self._forget_latched()
        return fresh

    def drop(self, latch: Latch) -> None:
        """Take note that a pair was torn apart."""
        self.latches.remove(latch)

    def fail(self, boat: int, face: Face) -> list[Latch]:
        """Switch a magnet off for good; return what it held."""
        self._kinds[boat, face] = 0
        let_go = [one for one in self.latches if (boat, face) in ((one.boat, one.face), (one.other, one.other_face))]
        self.latches = [one for one in self.latches if one not in let_go]
        pairs = self._pairs
        mine = ((pairs.boats == boat) & (pairs.faces == face)) | ((pairs.others == boat) & (pairs.other_faces == face))
        self._pairs = _chosen(pairs, ~mine)
        return let_go

    def _pairs_of(self, near: IntArray) -> _Pairs:
        """Return all pairs of equipped sides of near boats (k, 2) that are not latched."""
        sides = np.array([(one, other) for one in Face for other in Face])
        boats, others = np.repeat(near, len(sides), axis=0).T if len(near) else np.zeros((2, 0), dtype=np.int64)
        faces, other_faces = np.tile(sides, (len(near), 1)).T
        kinds, other_kinds = self._kinds[boats, faces], self._kinds[others, other_faces]
        pairs = _Pairs(boats, faces, others, other_faces, self._joins[kinds, other_kinds])
        self._pairs = _chosen(pairs, (kinds > 0) & (other_kinds > 0))
        self._forget_latched()
        return self._pairs

    def _forget_latched(self) -> None:
        held = self.contacts
        pairs = self._pairs
        free = ~held[pairs.boats, pairs.faces] & ~held[pairs.others, pairs.other_faces]
        self._pairs = _chosen(pairs, free)

    def _geometry(self, poses: FloatArray) -> tuple[FloatArray, tuple[FloatArray, FloatArray], FloatArray]:
        """Return the gaps (k, 2), the normals of both sides (k, 2), and the cosine of how they face each other (k,)."""
        pairs = self._pairs
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])

        def normals(rows: IntArray, faces: IntArray) -> FloatArray:
            x, y = FACE_VECTORS[faces].T
            return np.column_stack([cos[rows] * x - sin[rows] * y, sin[rows] * x + cos[rows] * y])

        one, other = normals(pairs.boats, pairs.faces), normals(pairs.others, pairs.other_faces)
        gaps = poses[pairs.others, :2] - poses[pairs.boats, :2] + 0.5 * CELL_M * (other - one)
        return gaps, (one, other), -(one * other).sum(axis=1)


def _chosen(pairs: _Pairs, mask: BoolArray) -> _Pairs:
    return _Pairs(pairs.boats[mask], pairs.faces[mask], pairs.others[mask], pairs.other_faces[mask], pairs.joins[mask])
