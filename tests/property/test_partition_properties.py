"""Laws of shapes and partitions over generated contours."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import Point, Polygon

from mission_computer.shape import load_shape
from mission_computer.shape.validation import VERTICES_MAX
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.geometry.contour import signed_area
from swarm_msgs_py.partition import Method, PartitionConfig, check_fits, partition, partitioning
from swarm_msgs_py.partition.config import BubbleConfig, VoronoiConfig
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster
from swarm_msgs_py.types import FloatArray

# The laws hold wherever packings stop.
BRIEF = PartitionConfig(
    bubbles=BubbleConfig(annealing_iterations=60, healings=1, healing_iterations=20, iterations_max=40),
    voronoi=VoronoiConfig(starts=2, start_steps=8, finalists=1, steps_max=8),
)
METHODS = st.sampled_from(Method).map(lambda method: replace(BRIEF, method=method))


@st.composite
def contours(draw: st.DrawFn) -> FloatArray:
    """Star-shaped simple polygons of 3 to 20 vertices, some with deep notches, 2 to 14 m in radius."""
    count = draw(st.integers(3, 20))
    size = draw(st.floats(2.0, 8.0))
    stretches = draw(st.lists(st.floats(0.25, 1.75), min_size=count, max_size=count))
    shift = draw(st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)))
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return (size * np.array(stretches))[:, None] * np.column_stack([np.cos(angles), np.sin(angles)]) + shift


rosters = st.lists(st.sampled_from(THESIS_TYPES), min_size=1, max_size=12).map(Roster.of)


@settings(max_examples=40)
@given(contours(), rosters, METHODS)
def test_goals_of_any_shape_are_circles_inside_it_that_do_not_overlap(
    points: FloatArray, roster: Roster, config: PartitionConfig
) -> None:
    contour = load_shape(points)
    try:
        goals = partition(contour, roster, config=config)
    except ShapeError:
        assume(False)
    radii = roster.radii_of(goals.types)
    shape = Polygon(contour)
    apart = np.linalg.norm(goals.positions[:, None] - goals.positions, axis=2) - radii[:, None] - radii
    np.fill_diagonal(apart, np.inf)

    assert np.array_equal(np.sort(goals.types), np.sort(roster.interleaved_types()))
    assert all(shape.contains(Point(p).buffer(r)) for p, r in zip(goals.positions, radii, strict=True))
    assert apart.min() > 0.29
    partitioning._partition.cache_clear()  # computed anew, not remembered
    again = partition(contour, roster, config=config)
    assert again.positions.tobytes() == goals.positions.tobytes()
    assert again.types.tobytes() == goals.types.tobytes()


@settings(max_examples=20)
@given(contours(), rosters, METHODS)
def test_the_quick_check_refuses_exactly_what_the_partition_refuses(
    points: FloatArray, roster: Roster, config: PartitionConfig
) -> None:
    contour = load_shape(points, scale=0.35)

    def complaint(judge: object) -> str | None:
        try:
            judge(contour, roster, config=config)
        except ShapeError as error:
            return str(error)
        return None

    assert complaint(partition) == complaint(check_fits)


@given(contours(), st.floats(0.1, 3.0), st.floats(-7.0, 7.0))
def test_scaling_and_turning_change_the_area_by_the_square_of_the_scale(
    points: FloatArray, scale: float, turn: float
) -> None:
    area = signed_area(load_shape(points))

    assert signed_area(load_shape(points, scale=scale, rotation=turn)) == pytest.approx(scale**2 * area, rel=1e-9)


@given(contours(), st.integers(7, 40))
def test_extra_vertices_on_the_contour_are_thinned_without_loss_of_area(points: FloatArray, between: int) -> None:
    along = np.arange(between)[:, None] / between
    dense = np.concatenate([p + along * (q - p) for p, q in zip(points, np.roll(points, -1, axis=0), strict=True)])

    thinned = load_shape(dense)

    assert len(thinned) <= VERTICES_MAX
    assert signed_area(thinned) == pytest.approx(signed_area(points), rel=1e-3)


@given(st.lists(st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 2), max_size=8))
def test_any_points_give_a_shape_or_one_line_that_says_why_not(points: list[tuple[float, float]]) -> None:
    complaint = None
    try:
        contour = load_shape(points)
    except ShapeError as error:
        complaint = str(error)

    if complaint is None:
        assert Polygon(contour).is_valid
        assert signed_area(contour) > 0.0
    else:
        assert complaint.startswith("inline shape: ")
        assert "\n" not in complaint
