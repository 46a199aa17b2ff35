from dataclasses import astuple, replace

import numpy as np
import pytest
from packed_shapes import BANDED, COMPACT, FORMATIONS, centers_of, field_domain, quality_of
from rosters import FIELD
from shapely import Point, Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.geometry.contour import area_centroid, boundary_center
from swarm_msgs_py.geometry.contour_integrals import ContourIntegrals
from swarm_msgs_py.geometry.mesh_quality import mesh_quality
from swarm_msgs_py.partition import Method, PartitionConfig, own_frame, partition, voronoi
from swarm_msgs_py.partition import domain as partition_domain
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.cell_integrals import CellMoments, Region
from swarm_msgs_py.partition.config import BubbleConfig, Gaps, VoronoiConfig
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.mesh_comparison import MeshComparison, Standing
from swarm_msgs_py.partition.power_diagram import PowerDiagram
from swarm_msgs_py.partition.voronoi import CentroidalVoronoi
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

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


@pytest.mark.parametrize("name", ["formation_1", "formation_3", "iso_1_circle"])
def test_robots_whose_last_bits_differ_get_the_same_goals(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    domain, noise = field_domain(name), np.random.default_rng(8)
    exact = CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(domain)
    moments, sums = Region.moments, ContourIntegrals.sums

    def shaken(values: FloatArray) -> FloatArray:
        noisy: FloatArray = values * (1.0 + 4e-16 * noise.normal(size=values.shape))
        return noisy

    def shaken_moments(region: Region, diagram: PowerDiagram) -> CellMoments:
        found = moments(region, diagram)
        return replace(found, areas=shaken(found.areas), firsts=shaken(found.firsts))

    def shaken_sums(contour: ContourIntegrals, across: FloatArray, at_tails: FloatArray) -> FloatArray:
        return shaken(sums(contour, across, at_tails))

    monkeypatch.setattr(Region, "moments", shaken_moments)
    monkeypatch.setattr(ContourIntegrals, "sums", shaken_sums)
    monkeypatch.setattr(own_frame, "area_centroid", lambda contour: shaken(area_centroid(contour)))
    for module in (own_frame, partition_domain):
        monkeypatch.setattr(module, "boundary_center", lambda contour: shaken(boundary_center(contour)))
    other = CentroidalVoronoi(BRIEF, BRIEF_PACKING).place(field_domain(name))

    assert exact is not None
    assert other is not None
    assert other.tobytes() == exact.tobytes()


def test_large_robots_get_larger_cells_as_their_share_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the setting alone: usually metrics choose among several shares, and they know of gaps and not of the share."""
    monkeypatch.setattr(voronoi, "TRADE_OFFS", ((1.0, 1.0),))
    monkeypatch.setattr(voronoi, "GOOD_TOTAL", np.inf)
    monkeypatch.setattr(MeshComparison, "standing", lambda *_, **__: Standing(0.0, 0.0, False))
    domain = field_domain("formation_3")

    def mean_gap_of_large_over_small(share: float) -> float:
        sites = CentroidalVoronoi(replace(BRIEF, radius_share=share), BRIEF_PACKING).place(domain)
        assert sites is not None
        apart = np.linalg.norm(sites[:, None] - sites, axis=2)
        np.fill_diagonal(apart, np.inf)
        depths = np.array([Polygon(domain.contour).exterior.distance(Point(p)) for p in sites])
        inner = depths > domain.spacing
        nearest = np.sort(apart, axis=1)[:, :6].mean(axis=1)
        return float(nearest[inner & (domain.radii == 0.5)].mean() / nearest[inner & (domain.radii == 0.15)].mean())

    assert mean_gap_of_large_over_small(1.0) > 1.015 * mean_gap_of_large_over_small(0.0)


@pytest.mark.parametrize(("name", "scale"), [("formation_1", 0.5)])
def test_in_a_shape_with_little_room_no_metric_finds_goals_worse_than_the_packing(name: str, scale: float) -> None:
    domain = field_domain(name).scaled(scale)
    goals, packed = CentroidalVoronoi(VoronoiConfig()).place(domain), BubblePacking(BubbleConfig()).place(domain)
    assert goals is not None
    assert packed is not None

    found, standard = (astuple(mesh_quality(centers, domain.radii, domain.contour)) for centers in (goals, packed))

    *irregular, covered = (value <= known for value, known in zip(found, standard, strict=True))
    assert all(irregular)
    assert not covered or found[-1] == standard[-1]


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
