"""What the methods reach against each other and against controls, on the shapes of the thesis' tables."""

from statistics import fmean

import numpy as np
import pytest
from packed_shapes import FORMATIONS, ISO_AREA, centers_of, field_domain, quality_of, random_points

from swarm_msgs_py.geometry.mesh_quality import MeshQuality, mesh_quality
from swarm_msgs_py.partition import Method

SEEDS = range(6)
BUBBLES, FRACTALS, VORONOI = Method.BUBBLE_PACKING, Method.FRACTALS, Method.VORONOI


def all_nodes(quality: MeshQuality) -> float:
    assert quality.topological is not None
    return quality.topological


def triangles(quality: MeshQuality) -> float:
    assert quality.geometrical is not None
    return quality.geometrical


def test_fractals_are_less_regular_than_bubbles_as_in_the_thesis() -> None:
    topological, geometrical = [], []
    for name in FORMATIONS:
        bubbles = quality_of(BUBBLES, name)
        fractals = [quality_of(FRACTALS, name, seed=seed) for seed in SEEDS]
        topological.append(fmean(map(all_nodes, fractals)) / all_nodes(bubbles))
        geometrical.append(fmean(map(triangles, fractals)) / triangles(bubbles))

    assert min(topological) >= 1.05
    assert fmean(topological) >= 1.15
    assert min(geometrical) >= 5.0


def test_irregularity_grows_with_the_perimeter_at_equal_area() -> None:
    values = [all_nodes(quality_of(BUBBLES, name)) for name in ISO_AREA]

    assert values == sorted(set(values))
    assert values[-1] - values[0] >= 0.8


@pytest.mark.parametrize("method", [BUBBLES, VORONOI])
@pytest.mark.parametrize("name", FORMATIONS)
def test_meshes_are_far_from_random(method: Method, name: str) -> None:
    domain = field_domain(name)
    controls = [mesh_quality(random_points(name, seed), domain.radii, domain.contour) for seed in range(3)]

    quality = quality_of(method, name)

    assert quality.topological_interior is not None
    assert quality.area_variation is not None
    assert quality.topological_interior < 0.4 * min(c.topological_interior or 0.0 for c in controls)
    assert triangles(quality) < 0.15 * min(map(triangles, controls))
    assert quality.area_variation < 0.3 * min(c.area_variation or 0.0 for c in controls)


@pytest.mark.parametrize("name", FORMATIONS + ISO_AREA)
def test_no_metric_finds_cells_worse_than_bubbles(name: str) -> None:
    bubbles, voronoi = (quality_of(method, name) for method in (BUBBLES, VORONOI))

    for metric in (
        all_nodes,
        triangles,
        lambda quality: quality.topological_interior,
        lambda quality: quality.geometrical_cells,
        lambda quality: quality.area_variation,
        lambda quality: quality.gap_variation,
        lambda quality: 1.0 - quality.covered_fraction,
    ):
        assert metric(voronoi) <= metric(bubbles)


@pytest.mark.parametrize("method", list(Method))
def test_no_method_gives_two_robots_one_place(method: Method) -> None:
    centers = centers_of(method, "formation_4")

    apart = np.linalg.norm(centers[:, None] - centers, axis=2) + 100.0 * np.eye(len(centers))
    assert apart.min() > 0.6
