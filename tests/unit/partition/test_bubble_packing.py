import numpy as np
import pytest
from mesh_irregularity import mesh_irregularity
from rosters import FIELD

from mission_computer.shape import load_shape
from swarm_msgs_py.partition.bubble_packing import BubblePacking
from swarm_msgs_py.partition.config import BubbleConfig, BubbleLaw, Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.types import FloatArray

ROSTER = FIELD
FORMATIONS = ("formation_1", "formation_2", "formation_3", "formation_4")


def domain_of(shape: str | FloatArray) -> Domain:
    contour = load_shape(shape) if isinstance(shape, str) else shape
    return Domain(contour, (), ROSTER.radii_of(ROSTER.interleaved_types()), Gaps())


def packed(domain: Domain, **settings: object) -> FloatArray:
    centers = BubblePacking(BubbleConfig(**settings)).place(domain)
    assert centers is not None
    return centers


@pytest.mark.parametrize("name", FORMATIONS)
def test_meshes_of_the_formation_shapes_are_regular(name: str) -> None:
    domain = domain_of(name)

    mesh = mesh_irregularity(packed(domain), domain.contour)

    # A hexagonal lattice has 0; random points have about 1 and 0.25.
    assert mesh.topological_interior <= 0.25
    assert mesh.geometrical <= 0.025
    assert mesh.area_variation <= 0.12


@pytest.mark.parametrize("turn", [0.4, 1.7])
def test_mesh_quality_does_not_hang_on_the_orientation_of_the_shape(turn: float) -> None:
    domain = domain_of(load_shape("formation_3", rotation=turn))

    mesh = mesh_irregularity(packed(domain), domain.contour)

    assert mesh.topological_interior <= 0.25
    assert mesh.geometrical <= 0.025


def test_one_bubble_rests_in_the_middle_of_a_square() -> None:
    square = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])

    centers = packed(Domain(square, (), np.array([0.5]), Gaps()))

    np.testing.assert_allclose(centers, [[3.0, 3.0]], atol=1e-3)


def test_two_equal_bubbles_rest_symmetrically_in_a_rectangle() -> None:
    strip = np.array([[-4.0, -2.0], [4.0, -2.0], [4.0, 2.0], [-4.0, 2.0]])

    left, right = sorted(packed(Domain(strip, (), np.full(2, 0.3), Gaps())).tolist())

    assert left[0] == pytest.approx(-right[0], abs=5e-3)
    assert left[1] == pytest.approx(right[1], abs=5e-3) == pytest.approx(0.0, abs=5e-3)
    assert right[0] > 1.0


def test_a_share_of_the_radius_in_the_range_evens_the_free_gaps() -> None:
    domain = domain_of("formation_3")

    def gap_variation(eta: float) -> float:
        centers = packed(domain, eta=eta)
        apart = np.linalg.norm(centers[:, None] - centers, axis=2) - domain.radii[:, None] - domain.radii
        np.fill_diagonal(apart, np.inf)
        nearest_six = np.sort(apart, axis=1)[:, :6]
        return float(nearest_six.std() / nearest_six.mean())

    assert gap_variation(0.25) < gap_variation(0.0)


def test_the_law_of_the_thesis_leaves_the_rim_emptier_than_the_scaled_one() -> None:
    domain = domain_of("formation_1")

    scaled = mesh_irregularity(packed(domain), domain.contour)
    thesis = mesh_irregularity(packed(domain, law=BubbleLaw.THESIS), domain.contour)

    assert thesis.area_variation > 1.5 * scaled.area_variation


@pytest.mark.parametrize("name", ["formation_1", "hw_5_line"])
def test_equal_inputs_give_equal_bytes(name: str) -> None:
    domain = Domain(load_shape(name), (), np.array([0.16, 0.11, 0.08]), Gaps(robot_m=0.05, contour_m=0.02))

    assert packed(domain).tobytes() == packed(domain).tobytes()
