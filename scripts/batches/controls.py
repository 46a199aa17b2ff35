"""The controls beside the mesh qualities of a batch: a hexagonal lattice, and random points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from batches.cells import Cell
from batches.estimates import Estimate, estimate
from batches.quantities import Quantity
from bringup.layout import robot_types
from bringup.resolution import contour_of
from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.controls import hexagonal_lattices, random_points

DRAWS = 40
"""Sets of random points per shape."""

LATTICE, RANDOM = "(hexagonal lattice)", "(random points)"

FIELDS: Mapping[str, str] = {
    "mesh_topological_interior": "topological_interior",
    "mesh_topological": "topological",
    "mesh_geometrical": "geometrical",
    "mesh_geometrical_cells": "geometrical_cells",
    "cell_area_variation": "area_variation",
    "gap_variation": "gap_variation",
    "covered_fraction": "covered_fraction",
}
"""Attribute of `MeshQuality` by quantity."""


@dataclass(frozen=True, slots=True)
class Control:
    """One control at one place.

    Attributes
    ----------
    name : str
    qualities : tuple of MeshQuality
        Of its lattices or draws.
    is_random : bool
        Whether they are draws.
    """

    name: str
    qualities: tuple[MeshQuality, ...]
    is_random: bool

    def estimate(self, quantity: Quantity) -> Estimate | None:
        """Return the mean of one number; None for one that a mesh without robots does not have.

        Only what is drawn at random has an interval: the lattices are no sample of anything, but all that were laid.
        """
        if quantity.name not in FIELDS:
            return None
        found = [getattr(quality, FIELDS[quantity.name]) for quality in self.qualities]
        mean = estimate([value for value in found if value is not None], is_larger_worse=quantity.is_larger_worse)
        return mean if mean is None or self.is_random else replace(mean, deviation=None, low=None, high=None)


def controls(cell: Cell) -> tuple[Control, ...]:
    """Return the controls for the shape and the robots of a cell."""
    contour = contour_of(cell.scenario)
    radii = np.array([kind.coverage_radius_m for kind in robot_types(cell.scenario)])
    return _controls(contour.tobytes(), radii.tobytes())


@cache
def _controls(contour_bytes: bytes, radii_bytes: bytes) -> tuple[Control, ...]:
    contour, radii = np.frombuffer(contour_bytes).reshape(-1, 2), np.frombuffer(radii_bytes)

    def control(name: str, point_sets: list[FloatArray]) -> Control:
        return Control(name, tuple(mesh_quality(points, radii, contour) for points in point_sets), name == RANDOM)

    count = len(radii)
    drawn = [random_points(contour, count, rng_for(draw, "control", 0)) for draw in range(DRAWS)]
    return control(LATTICE, list(hexagonal_lattices(contour, count))), control(RANDOM, drawn)
