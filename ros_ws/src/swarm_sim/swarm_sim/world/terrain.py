"""Rough ground as a seeded height field: a sum of long waves, flat well beyond the arena."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import FloatArray
from swarm_sim.config import Ground, TerrainConfig

CELL_M = 1.0
"""Grid spacing of the height field [m]; larger facets cost less, smaller ones follow the waves no better."""
WAVES = 24
"""Number of plane waves; enough for heights that look Gaussian."""
SHORTEST_CELLS = 4.0
"""Shortest wavelength, in cells: what the grid can still show."""
STEEPEST = 0.35
"""Steepest slope that a robot can stand on: the lightest type topples at 0.38, and 8 N hold 1.5 kg up to 0.54."""
SHOULDER_M = 4.0
"""Width of the ring around the arena in which the waves fade out [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Terrain:
    """A height field on a square grid.

    Attributes
    ----------
    heights : (rows, columns) array
        Ground height at the grid points, row by row in ascending y [m].
    origin : (x, y)
        World position of the first grid point [m].
    """

    heights: FloatArray
    origin: tuple[float, float]

    @property
    def center(self) -> tuple[float, float]:
        """Return the world position of the middle of the grid [m]."""
        rows, columns = self.heights.shape
        return self.origin[0] + (columns - 1) * CELL_M / 2.0, self.origin[1] + (rows - 1) * CELL_M / 2.0

    def heights_at(self, points: FloatArray) -> FloatArray:
        """Return the ground height (n,) at points (n, 2) [m], whichever way the cells are cut into two triangles.

        Of the two possible surfaces the upper one counts, so that what is put at this height is not under ground.
        """
        rows, columns = self.heights.shape
        column, row = ((points - self.origin) / CELL_M).T
        j = np.clip(np.floor(column).astype(np.int64), 0, columns - 2)
        i = np.clip(np.floor(row).astype(np.int64), 0, rows - 2)
        u, v = np.clip(column - j, 0.0, 1.0), np.clip(row - i, 0.0, 1.0)
        a, b = self.heights[i, j], self.heights[i, j + 1]
        c, d = self.heights[i + 1, j], self.heights[i + 1, j + 1]
        main = np.where(u > v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))
        anti = np.where(u + v < 1.0, a + u * (b - a) + v * (c - a), d + (1.0 - u) * (c - d) + (1.0 - v) * (b - d))
        upper: FloatArray = np.maximum(main, anti)
        return upper


def make_terrain(config: TerrainConfig, bounds: tuple[float, float, float, float], seed: int) -> Terrain:
    """Return the ground of an arena.

    Parameters
    ----------
    config : TerrainConfig
    bounds : (x_min, y_min, x_max, y_max)
        The arena [m].
    seed : int
        Seed of the run.

    Raises
    ------
    ConfigError
        If the ground would be too steep to stand on.
    """
    x_min, y_min, x_max, y_max = bounds
    origin = (x_min - config.margin_m, y_min - config.margin_m)
    columns = math.ceil((x_max - x_min + 2.0 * config.margin_m) / CELL_M) + 1
    rows = math.ceil((y_max - y_min + 2.0 * config.margin_m) / CELL_M) + 1
    x, y = np.meshgrid(origin[0] + CELL_M * np.arange(columns), origin[1] + CELL_M * np.arange(rows))
    if config.ground is Ground.PLANE or config.amplitude_m == 0.0:
        return Terrain(np.zeros((rows, columns)), origin)
    waves = _waves(config, x, y, seed)
    outside = np.hypot(
        np.maximum(np.maximum(x_min - x, x - x_max), 0.0), np.maximum(np.maximum(y_min - y, y - y_max), 0.0)
    )
    fade = np.clip(1.0 - outside / min(SHOULDER_M, config.margin_m / 2.0), 0.0, 1.0)
    heights: FloatArray = waves * (3.0 - 2.0 * fade) * fade**2  # smooth step: no edge at the shoulder
    steepest = float(np.hypot(np.diff(heights, axis=0)[:, 1:], np.diff(heights, axis=1)[1:]).max()) / CELL_M
    if steepest > STEEPEST:
        raise ConfigError(
            f"terrain: slopes of up to {steepest:.2f} topple robots (limit {STEEPEST:g}); lower amplitude_m or "
            "roughness, or raise wavelength_m"
        )
    return Terrain(heights, origin)


def _waves(config: TerrainConfig, x: FloatArray, y: FloatArray, seed: int) -> FloatArray:
    """Return heights of standard deviation `amplitude_m` at the points."""
    rng = rng_for(seed, "terrain")
    shortest = min(SHORTEST_CELLS * CELL_M, config.wavelength_m)
    # Wavelengths evenly spread in octaves; `roughness` is the height of the shortest relative to the longest.
    share = np.linspace(0.0, 1.0, WAVES)
    numbers = 2.0 * np.pi / (config.wavelength_m * (shortest / config.wavelength_m) ** share)
    weights = (1.0 - share) + config.roughness * share
    weights *= config.amplitude_m * np.sqrt(2.0 / (weights**2).sum())
    # Golden-angle directions cover the circle evenly whatever the number of waves.
    directions = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(WAVES) + rng.uniform(0.0, 2.0 * np.pi)
    phases = rng.uniform(0.0, 2.0 * np.pi, WAVES)
    heights = np.zeros_like(x)
    for number, weight, direction, phase in zip(numbers, weights, directions, phases, strict=True):
        heights += weight * np.sin(number * (np.cos(direction) * x + np.sin(direction) * y) + phase)
    return heights
