"""Library shapes filled for the field's fifty robots, each computed once in a test run, and how regular they are."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from rosters import FIELD

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.method import METHODS
from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics import controls

FORMATIONS = ("formation_1", "formation_2", "formation_3", "formation_4")
COMPACT, BANDED = ("formation_1", "formation_3"), ("formation_2", "formation_4")
ISO_AREA = ("iso_1_circle", "iso_2_rect", "iso_3_rect", "iso_4_free")


def field_domain(shape: str, turn: float = 0.0) -> Domain:
    return Domain(
        load_shape(shape, rotation=turn), (), FIELD.radii_of(FIELD.interleaved_types()), PartitionConfig().gaps
    )


def centers_of(method: Method, shape: str, turn: float = 0.0, seed: int = 1) -> FloatArray:
    return _centers(method, shape, turn, seed)


def quality_of(method: Method, shape: str, turn: float = 0.0, seed: int = 1) -> MeshQuality:
    return _quality(method, shape, turn, seed)


@lru_cache
def _centers(method: Method, shape: str, turn: float, seed: int) -> FloatArray:
    config = PartitionConfig()
    config = replace(config, fractals=replace(config.fractals, seed=seed))
    centers = METHODS[method](config).place(field_domain(shape, turn))
    assert centers is not None
    centers.flags.writeable = False
    return centers


@lru_cache
def _quality(method: Method, shape: str, turn: float, seed: int) -> MeshQuality:
    domain = field_domain(shape, turn)
    return mesh_quality(_centers(method, shape, turn, seed), domain.radii, domain.contour)


def random_points(shape: str, seed: int) -> FloatArray:
    """Fifty points drawn evenly from a library shape."""
    domain = field_domain(shape)
    return controls.random_points(domain.contour, len(domain.radii), np.random.default_rng(seed))
