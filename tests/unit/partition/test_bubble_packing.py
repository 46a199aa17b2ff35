import numpy as np
import pytest
from mesh_irregularity import mesh_irregularity
from packed_shapes import COMPACT, FORMATIONS, centers_of, field_domain
from shapely import Polygon

from mission_computer.shape import load_shape
from swarm_msgs_py.partition import Method
from swarm_msgs_py.partition.bubble_packing import ALL_WEIGHT, BubblePacking
from swarm_msgs_py.partition.cell_integrals import Region
from swarm_msgs_py.partition.config import BubbleConfig, BubbleLaw, Gaps
from swarm_msgs_py.partition.domain import Domain
from swarm_msgs_py.partition.mesh_energy import MeshEnergy
from swarm_msgs_py.partition.own_frame import OwnFrame
from swarm_msgs_py.types import FloatArray

SHORT = {"starts": 1, "healings": 0}


def packed(domain: Domain, **settings: object) -> FloatArray:
    centers = BubblePacking(BubbleConfig(**settings)).place(domain)
    assert centers is not None
    return centers


@pytest.mark.parametrize(("name", "turn"), [*((name, 0.0) for name in FORMATIONS), ("formation_3", 1.7)])
def test_meshes_of_the_formation_shapes_are_regular_however_they_are_turned(name: str, turn: float) -> None:
    mesh = mesh_irregularity(centers_of(Method.BUBBLE_PACKING, name, turn), field_domain(name, turn).contour)

    # A hexagonal lattice has 0; random points have about 1 and 0.18.
    assert mesh.topological_interior <= 0.25
    assert mesh.geometrical <= 0.02
    assert mesh.area_variation <= 0.12
    # Cells on the contour cannot have six neighbors; one of them more or less of fifty is 0.04.
    assert mesh.topological_all <= (1.15 if name in COMPACT else 1.44)


def test_one_bubble_rests_in_the_middle_of_a_square() -> None:
    square = np.array([[0.0, 0.0], [6.0, 0.0], [6.0, 6.0], [0.0, 6.0]])

    centers = packed(Domain(square, (), np.array([0.5]), Gaps()))

    np.testing.assert_allclose(centers, [[3.0, 3.0]], atol=1e-3)


def test_two_equal_bubbles_rest_symmetrically_in_a_rectangle() -> None:
    strip = np.array([[-4.0, -2.0], [4.0, -2.0], [4.0, 2.0], [-4.0, 2.0]])

    left, right = sorted(packed(Domain(strip, (), np.full(2, 0.3), Gaps())).tolist())

    assert left[0] == pytest.approx(-right[0], abs=5e-3)
    assert [left[1], right[1]] == pytest.approx([0.0, 0.0], abs=5e-3)
    assert right[0] > 1.0


def test_a_share_of_the_radius_in_the_range_evens_the_free_gaps() -> None:
    domain = field_domain("formation_3")

    def gap_variation(eta: float) -> float:
        centers = packed(domain, eta=eta, **SHORT)
        apart = np.linalg.norm(centers[:, None] - centers, axis=2) - domain.radii[:, None] - domain.radii
        np.fill_diagonal(apart, np.inf)
        nearest_six = np.sort(apart, axis=1)[:, :6]
        return float(nearest_six.std() / nearest_six.mean())

    assert gap_variation(0.25) < gap_variation(0.0)


def test_the_law_of_the_thesis_leaves_the_rim_emptier_than_the_scaled_one() -> None:
    domain = field_domain("formation_1")

    scaled = mesh_irregularity(packed(domain, **SHORT), domain.contour)
    thesis = mesh_irregularity(packed(domain, law=BubbleLaw.THESIS, **SHORT), domain.contour)

    assert thesis.area_variation > 1.5 * scaled.area_variation


@pytest.mark.parametrize("name", ["formation_1", "hw_5_line"])
def test_equal_inputs_give_equal_bytes(name: str) -> None:
    domain = Domain(load_shape(name), (), np.array([0.16, 0.11, 0.08]), Gaps(robot_m=0.05, contour_m=0.02))

    assert packed(domain).tobytes() == packed(domain).tobytes()


def test_bubbles_that_settle_on_come_to_rest() -> None:
    domain = field_domain("formation_1")

    early, late, later = (packed(domain, **SHORT, iterations_max=count) for count in (10, 4000, 4400))

    assert np.abs(late - later).max() < 1e-3 < np.abs(early - late).max()


def test_moves_of_crowded_bubbles_into_holes_make_a_mesh_more_regular() -> None:
    domain = field_domain("formation_2")
    frame = OwnFrame(domain.contour)
    shape = Polygon(frame.enter(domain.contour))
    mesh = MeshEnergy(Region(shape), shape.area, np.zeros(len(domain.radii)), 0.0)

    def irregularity(healings: int) -> float:
        # Short annealing leaves something to heal; what follows the healing is cut off.
        centers = packed(domain, starts=1, annealing_iterations=100, healings=healings, iterations_max=1)
        return mesh.irregularity(frame.enter(centers), ALL_WEIGHT)

    assert irregularity(12) < irregularity(0) - 0.2
