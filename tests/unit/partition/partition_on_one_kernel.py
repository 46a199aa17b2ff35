"""Prints checksums of partitions, one per line, after one of a matrix product; a test runs it on several kernels."""

import sys
import zlib
from dataclasses import replace

import numpy as np
from packed_shapes import FORMATIONS, ISO_AREA, centers_of, field_domain

from swarm_msgs_py.partition import Method
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.config import BubbleConfig, VoronoiConfig
from swarm_msgs_py.partition.fractals import FractalConfig, RandomizedFractals
from swarm_msgs_py.partition.voronoi import CentroidalVoronoi

TURN = 0.37  # rad
BRIEF = VoronoiConfig(starts=2, finalists=1)
BRIEF_PACKING = BubbleConfig(starts=2, annealing_iterations=60, healings=1, healing_iterations=20, iterations_max=60)


def show(name: str, values: np.ndarray | None) -> None:
    assert values is not None
    sys.stdout.write(f"{name} {zlib.crc32(values.tobytes()):08x}\n")


def main() -> None:
    factor = np.random.default_rng(1).normal(size=(50, 50))
    show("product", factor @ factor)
    for name in (*FORMATIONS, ISO_AREA[0]):
        turned = field_domain(name, TURN)
        domain = replace(turned, contour=turned.contour.round(2))  # robots know shapes in whole centimeters
        show(f"{name} bubbles", BubblePacking(BRIEF_PACKING).place(domain))
        show(f"{name} voronoi", CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(domain))
    show("fractals", RandomizedFractals(FractalConfig(seed=1)).place(domain))
    show("full settings", centers_of(Method.VORONOI, FORMATIONS[2]))


if __name__ == "__main__":
    main()
