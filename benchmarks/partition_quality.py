"""Mesh quality of every partition method, beside a hexagonal lattice and random points: prints Markdown tables.

python benchmarks/partition_quality.py [--shapes NAME ...] [--turns N] [--seeds N]

Shapes are turned, since a method may owe a good mesh to one orientation; randomized fractals are drawn from several
seeds too. Values are means over orientations and seeds, with the worst in parentheses. The controls hold what no method
knows: the interior of an endless hexagonal lattice cut out by the shape, and points drawn evenly from the shape.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from time import process_time

import numpy as np

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.partition import Method, PartitionConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.method import METHODS
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray
from swarm_sim.metrics.controls import hexagonal_lattices, random_points

FORMATIONS = ("formation_1", "formation_2", "formation_3", "formation_4")
ISO_AREA = ("iso_1_circle", "iso_2_rect", "iso_3_rect", "iso_4_free")
FIELD = Roster.of(kind for kind, count in zip(THESIS_TYPES, (17, 17, 16), strict=True) for _ in range(count))
FIRST_TURN = 0.05  # [rad]; shapes are drawn along the axes, which no orientation here is to meet
BUBBLES, FRACTALS, VORONOI = Method.BUBBLE_PACKING.value, Method.FRACTALS.value, Method.VORONOI.value

COLUMNS: dict[str, Callable[[MeshQuality], float | None]] = {
    "eps_t interior": lambda quality: quality.topological_interior,
    "eps_t all": lambda quality: quality.topological,
    "eps_g": lambda quality: quality.geometrical,
    "eps_g cells": lambda quality: quality.geometrical_cells,
    "area variation": lambda quality: quality.area_variation,
    "gap variation": lambda quality: quality.gap_variation,
    "uncovered": lambda quality: 1.0 - quality.covered_fraction,
}
"""All of them: the less, the better."""


@dataclass(frozen=True)
class Sample:
    """One partition and what it took."""

    quality: MeshQuality
    cpu_s: float


Samples = dict[str, dict[str, list[Sample]]]
"""Per shape and method."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the tables; return 1 if a method failed on a shape."""
    options = _parser().parse_args(arguments)
    samples: Samples = {}
    _print_row(["shape", "method", *COLUMNS, "CPU time [s]"])
    _print_row(["---"] * (3 + len(COLUMNS)))
    for shape in options.shapes:
        samples[shape] = _measured(shape, options.turns, options.seeds)
        for name, found in samples[shape].items():
            cells = [_cell([column(sample.quality) for sample in found]) for column in COLUMNS.values()]
            _print_row([shape, name, *cells, _cell([sample.cpu_s for sample in found])])
    formations = {shape: found for shape, found in samples.items() if shape in FORMATIONS}
    if formations:
        _print_ratios(formations)
    if all(shape in samples for shape in ISO_AREA):
        _print_sensitivity(samples)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=[*FORMATIONS, *ISO_AREA], help="default: formation and iso-area")
    parser.add_argument("--turns", type=int, default=5, help="orientations of each shape (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=8, help="draws per orientation (default: %(default)s)")
    return parser


def _measured(shape: str, turns: int, seeds: int) -> dict[str, list[Sample]]:
    """Return the samples of every method and control."""
    found: dict[str, list[Sample]] = {}
    for turn in range(turns):
        contour = load_shape(shape, rotation=FIRST_TURN + 2.0 * np.pi * turn / turns)
        domain = Domain(contour, (), FIELD.radii_of(FIELD.interleaved_types()), PartitionConfig().gaps)
        for method in Method:
            for config in _configs(method, seeds):
                start = process_time()
                centers = METHODS[method](config).place(domain)
                spent = process_time() - start
                if centers is None:
                    sys.exit(f"{method.value} found no room in {shape}")
                found.setdefault(method.value, []).append(_sample(domain, centers, spent))
        for centers in hexagonal_lattices(contour, len(domain.radii)):
            found.setdefault("(hexagonal lattice)", []).append(_sample(domain, centers, 0.0))
        for seed in range(seeds):
            drawn = random_points(contour, len(domain.radii), rng_for(seed, "control", turn))
            found.setdefault("(random points)", []).append(_sample(domain, drawn, 0.0))
    return found


def _configs(method: Method, seeds: int) -> Iterable[PartitionConfig]:
    config = PartitionConfig(method=method)
    if method is not Method.FRACTALS:
        return [config]
    return [replace(config, fractals=replace(config.fractals, seed=seed)) for seed in range(seeds)]


def _sample(domain: Domain, centers: FloatArray, spent: float) -> Sample:
    return Sample(mesh_quality(centers, domain.radii, domain.contour), spent)


def _print_ratios(samples: Samples) -> None:
    """Print fractals over bubbles, and Voronoi over bubbles."""
    for above, title in ((FRACTALS, "Fractals over bubbles"), (VORONOI, "Voronoi over bubbles (1 or less: not worse)")):
        print(f"\n### {title}\n")
        _print_row(["shape", *COLUMNS])
        _print_row(["---"] * (1 + len(COLUMNS)))
        ratios = {
            shape: [_mean(found[above], column) / _mean(found[BUBBLES], column) for column in COLUMNS.values()]
            for shape, found in samples.items()
        }
        for shape, values in ratios.items():
            _print_row([shape, *(f"{value:.3f}" for value in values)])
        _print_row(["mean", *(f"{fmean(values):.3f}" for values in zip(*ratios.values(), strict=True))])


def _print_sensitivity(samples: Samples) -> None:
    """Print how the irregularity of all nodes grows with the perimeter at equal area (thesis table 4.3)."""
    print("\n### Sensitivity: eps_t of all nodes at 314 m^2\n")
    _print_row(["method", *ISO_AREA, "rise"])
    _print_row(["---"] * (2 + len(ISO_AREA)))
    for method in samples[ISO_AREA[0]]:
        values = [_mean(samples[shape][method], COLUMNS["eps_t all"]) for shape in ISO_AREA]
        _print_row([method, *(f"{value:.3f}" for value in values), f"{values[-1] - values[0]:.3f}"])


def _mean(samples: Sequence[Sample], column: Callable[[MeshQuality], float | None]) -> float:
    return fmean(value for sample in samples if (value := column(sample.quality)) is not None)


def _cell(values: Sequence[float | None]) -> str:
    known = [value for value in values if value is not None]
    return f"{fmean(known):.3f} ({max(known):.3f})" if known else "-"


def _print_row(cells: Sequence[str]) -> None:
    print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    sys.exit(main())
