from dataclasses import replace

import numpy as np
import pytest
from packed_shapes import BANDED, COMPACT, FORMATIONS, centers_of, field_domain, quality_of
from rosters import FIELD
from shapely import Point, Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.partition import Method, PartitionConfig, partition
from swarm_msgs_py.partition.cell_integrals import CellMoments, Region
from swarm_msgs_py.partition.config import BubbleConfig, Gaps, VoronoiConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.lattice_starts import lattice_starts
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.partition.power_diagram import PowerDiagram
from swarm_msgs_py.partition.quasi_newton import minimize
from swarm_msgs_py.partition.spreading import spread_sizes
from swarm_msgs_py.partition.voronoi import CentroidalVoronoi
from swarm_msgs_py.roster import Roster

BRIEF = VoronoiConfig(starts=3, finalists=1)
BRIEF_PACKING = BubbleConfig(starts=1, annealing_iterations=100, healings=1, healing_iterations=40, iterations_max=100)
VORONOI = PartitionConfig(method=Method.VORONOI, voronoi=BRIEF, bubbles=BRIEF_PACKING)


@pytest.mark.parametrize("name", FORMATIONS)
def test_cells_of_the_formation_shapes_are_even(name: str) -> None:
    quality = quality_of(Method.VORONOI, name)

    assert quality.topological_interior is not None
    assert quality.topological is not None
    assert quality.geometrical is not None
    assert quality.area_variation is not None
    assert quality.topological_interior <= 0.25
    assert quality.geometrical <= 0.015
    assert quality.area_variation <= 0.12
    assert quality.topological <= (1.15 if name in COMPACT else 1.42)
    assert name in COMPACT + BANDED
    assert quality.covered_fraction >= 0.99


def test_goals_are_in_whole_centimeters() -> None:
    centers = centers_of(Method.VORONOI, "formation_1")

    np.testing.assert_array_equal(centers, centers.round(2))


@pytest.mark.parametrize("turn", [0.9, 4.0])
def test_a_turned_shape_gets_the_turned_goals(turn: float) -> None:
    goals, turned = (
        partition(load_shape("formation_2", rotation=angle, translation=shift), FIELD, config=VORONOI)
        for angle, shift in ((0.0, (0.0, 0.0)), (turn, (12.0, -7.0)))
    )

    turning = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    before, after = load_shape("formation_2"), load_shape("formation_2", rotation=turn, translation=(12.0, -7.0))
    expected = (goals.positions - before[0]) @ turning.T + after[0]
    # Two roundings to a centimeter.
    np.testing.assert_allclose(turned.positions, expected, atol=0.0145)
    np.testing.assert_array_equal(turned.types, goals.types)


def test_robots_whose_last_bits_differ_get_the_same_goals(monkeypatch: pytest.MonkeyPatch) -> None:
    domain, noise = field_domain("formation_4"), np.random.default_rng(8)
    exact = CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(domain)
    moments = Region.moments

    def rounded_differently(region: Region, diagram: PowerDiagram) -> CellMoments:
        found = moments(region, diagram)
        return replace(
            found,
            areas=found.areas * (1.0 + 4e-16 * noise.normal(size=found.areas.shape)),
            firsts=found.firsts * (1.0 + 4e-16 * noise.normal(size=found.firsts.shape)),
        )

    monkeypatch.setattr(Region, "moments", rounded_differently)
    other = CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(domain)

    assert exact is not None
    assert other is not None
    assert other.tobytes() == exact.tobytes()


def test_large_robots_get_larger_cells_as_their_share_grows() -> None:
    """Of one descent: which of them wins is up to the metrics, which know of gaps but not of the share."""
    domain = field_domain("formation_3")
    shape = Polygon(OwnFrame(domain.contour).enter(domain.contour))
    (lattice,) = lattice_starts(shape, domain.spacing, len(domain.radii), 1)
    start = spread_sizes(domain, lattice)

    def mean_gap_of_large_over_small(share: float) -> float:
        energy = MeshEnergy(Region(shape), shape.area, share * domain.spacing * domain.radii, 0.15)
        sites = minimize(energy, start, step_max=0.3 * domain.spacing, tolerance=1e-3, steps_max=60)
        apart = np.linalg.norm(sites[:, None] - sites, axis=2)
        np.fill_diagonal(apart, np.inf)
        depths = np.array([shape.exterior.distance(Point(p)) for p in sites])
        inner = depths > domain.spacing
        nearest = np.sort(apart, axis=1)[:, :6].mean(axis=1)
        return float(nearest[inner & (domain.radii == 0.5)].mean() / nearest[inner & (domain.radii == 0.15)].mean())

    assert mean_gap_of_large_over_small(1.0) > 1.015 * mean_gap_of_large_over_small(0.0)


def test_one_robot_stands_in_the_center_of_its_shape() -> None:
    triangle = np.array([[0.0, 0.0], [6.0, 0.0], [0.0, 6.0]])

    centers = CentroidalVoronoi(VoronoiConfig()).place(Domain(triangle, (), np.array([0.3]), Gaps()))

    assert centers is not None
    np.testing.assert_allclose(centers, [[2.0, 2.0]], atol=0.01)


def test_two_robots_share_a_rectangle() -> None:
    strip = np.array([[-4.0, -2.0], [4.0, -2.0], [4.0, 2.0], [-4.0, 2.0]])

    centers = CentroidalVoronoi(VoronoiConfig()).place(Domain(strip, (), np.full(2, 0.3), Gaps()))

    assert centers is not None
    np.testing.assert_allclose(sorted(centers.tolist()), [[-2.0, 0.0], [2.0, 0.0]], atol=0.01)


def test_cells_end_at_what_stands_in_the_shape() -> None:
    square = np.array([[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]])
    wall = np.array([[-0.3, -4.0], [0.3, -4.0], [0.3, 2.0], [-0.3, 2.0]])
    roster = Roster(groups=FIELD.without([1] * 13 + [2] * 13 + [3] * 16).groups)

    goals = partition(square, roster, config=VORONOI, keep_outs=(wall,))

    gaps = [
        Polygon(wall).distance(Point(p)) - r for p, r in zip(goals.positions, roster.radii_of(goals.types), strict=True)
    ]
    assert min(gaps) >= VORONOI.gaps.obstacle_m - 1e-6
    assert 3 <= np.count_nonzero(goals.positions[:, 0] < 0.0) <= 5


def test_in_a_tight_shape_goals_keep_their_gaps_after_rounding() -> None:
    square = np.array([[0.0, 0.0], [3.5, 0.0], [3.5, 3.5], [0.0, 3.5]])
    domain = Domain(square, (), np.full(4, 0.5), Gaps())

    centers = CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(domain)

    assert centers is not None
    apart = np.linalg.norm(centers[:, None] - centers, axis=2)[np.triu_indices(4, 1)]
    assert apart.min() >= 1.3
    assert Polygon(square).buffer(-0.65 + 1e-9).contains(Point(centers[0]))
