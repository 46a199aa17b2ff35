import re

import numpy as np
import pytest
from rosters import FIELD, TABLE
from shapely import Point, Polygon

from mission_computer.shape import library_names, load_shape
from mission_computer.shape.arena import load_arena
from swarm_msgs_py.errors import ShapeError
from swarm_msgs_py.partition import PartitionConfig, adapt, check_fits, forget, partition
from swarm_msgs_py.partition.config import BubbleConfig, Gaps
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster

ARENA = load_arena("arena_main")
TABLE_ARENA = load_arena("arena_table")
# The rules hold however well bubbles are packed.
QUICK = BubbleConfig(starts=1, annealing_iterations=150, healings=0, iterations_max=100)
BRIEF = PartitionConfig(bubbles=QUICK)
NARROW = PartitionConfig(gaps=Gaps(robot_m=0.03, contour_m=0.02, obstacle_m=0.05), bubbles=QUICK)


@pytest.mark.parametrize("name", library_names())
def test_every_library_shape_holds_the_swarm_that_it_is_made_for(name: str) -> None:
    is_small = name.startswith("hw_")
    arena, roster, config = (TABLE_ARENA, TABLE, NARROW) if is_small else (ARENA, FIELD, BRIEF)
    contour = load_shape(name)

    goals = partition(contour, roster, tuple(wall.polygon() for wall in arena.obstacles), config)

    radii = roster.radii_of(goals.types)
    border = Polygon(contour).exterior
    apart = np.linalg.norm(goals.positions[:, None] - goals.positions, axis=2) - radii[:, None] - radii
    np.fill_diagonal(apart, np.inf)
    assert sorted(goals.types) == sorted(roster.interleaved_types())
    assert apart.min() >= config.gaps.robot_m - 1e-5
    assert all(Polygon(contour).contains(Point(p)) for p in goals.positions)
    assert min(border.distance(Point(p)) - r for p, r in zip(goals.positions, radii, strict=True)) >= (
        config.gaps.contour_m - 1e-5
    )


def test_each_type_is_spread_over_the_whole_shape() -> None:
    contour = load_shape("formation_3")
    goals = partition(contour, FIELD)

    for number in (1, 2, 3):
        own = goals.positions[goals.types == number]
        # In every half of the shape, cut any way through the center, stands at least a quarter of each type.
        for angle in np.linspace(0.0, np.pi, 6, endpoint=False):
            side = (own - contour.mean(axis=0)) @ [np.cos(angle), np.sin(angle)] > 0.0
            assert 0.25 <= side.mean() <= 0.75


@pytest.mark.parametrize("scale", [0.05, 0.2, 0.35])
def test_the_scale_that_is_asked_for_is_enough_and_little_less_is_not(scale: float) -> None:
    contour = load_shape("formation_2", scale=scale)

    with pytest.raises(ShapeError, match=r"a shape of .* m2 is too .*: needs .* m2; scale it by at least") as caught:
        partition(contour, FIELD)

    found = re.search(r"at least ([\d.]+)", str(caught.value))
    assert found is not None
    asked = float(found[1])
    check_fits(load_shape("formation_2", scale=scale * asked), FIELD)
    with pytest.raises(ShapeError):
        check_fits(load_shape("formation_2", scale=scale * asked * 0.9), FIELD)


def test_a_corridor_too_narrow_names_the_types_that_do_not_fit() -> None:
    corridor = np.array([[0.0, 0.0], [200.0, 0.0], [200.0, 1.0], [0.0, 1.0]])

    with pytest.raises(ShapeError, match=r"too narrow for robots of type 3 \(radius 0\.5 m\): needs"):
        check_fits(corridor, FIELD)


def test_where_turns_leave_no_room_large_robots_go_first() -> None:
    roster = Roster.of([THESIS_TYPES[0]] * 6 + [THESIS_TYPES[2]] * 4)
    tightest = None
    for side in np.arange(4.0, 2.5, -0.02):
        square = np.array([[0.0, 0.0], [side, 0.0], [side, side], [0.0, side]])
        try:
            check_fits(square, roster)
        except ShapeError:
            break
        tightest = square

    assert tightest is not None
    assert partition(tightest, roster, config=BRIEF).types.tolist() == [3] * 4 + [1] * 6


def test_a_shape_over_an_obstacle_names_it() -> None:
    contour = load_shape("formation_1", translation=(15.0, 10.0))

    with pytest.raises(ShapeError, match=r"obstacle 2 at \(22\.0, 20\.0\) covers .* m2 of the shape; move"):
        partition(contour, FIELD, tuple(wall.polygon() for wall in ARENA.obstacles))


def test_goals_keep_clear_of_an_obstacle_that_touches_the_shape() -> None:
    contour = load_shape("formation_3")
    right = contour[np.argmax(contour[:, 0])]
    wall = right + np.array([[0.01, -4.0], [1.0, -4.0], [1.0, 4.0], [0.01, 4.0]])
    config = PartitionConfig(gaps=Gaps(obstacle_m=1.5), bubbles=QUICK)

    goals = partition(contour, FIELD, (wall,), config)

    radii = FIELD.radii_of(goals.types)
    gaps = [Polygon(wall).distance(Point(p)) - r for p, r in zip(goals.positions, radii, strict=True)]
    assert min(gaps) >= 1.5 - 1e-6


def test_obstacles_that_leave_no_room_are_to_blame() -> None:
    square = np.array([[0.0, 0.0], [3.4, 0.0], [3.4, 3.4], [0.0, 3.4]])
    wall = np.array([[3.41, 0.0], [4.0, 0.0], [4.0, 3.4], [3.41, 3.4]])
    roster = Roster.of([THESIS_TYPES[2]] * 4)
    config = PartitionConfig(gaps=Gaps(obstacle_m=1.5), bubbles=QUICK)

    check_fits(square, roster, (), config)
    with pytest.raises(ShapeError, match="obstacles in or beside the shape leave too little room"):
        check_fits(square, roster, (wall,), config)


def test_a_keep_out_in_the_shape_is_no_error_but_goals_stay_clear_of_it() -> None:
    body = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    square = 8.0 * body

    goals = partition(square, Roster.of([THESIS_TYPES[1]] * 8), keep_outs=(body,))

    gaps = [Polygon(body).distance(Point(p)) - 0.3 for p in goals.positions]
    assert min(gaps) >= PartitionConfig().gaps.obstacle_m - 1e-6
    with pytest.raises(ShapeError, match="covers"):
        partition(square, Roster.of([THESIS_TYPES[1]] * 8), (body,))


def test_adapted_goals_move_only_where_they_must() -> None:
    square = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    roster = Roster.of([THESIS_TYPES[1]] * 9)
    goals = partition(square, roster, config=BRIEF)
    x, y = goals.positions[4]
    body = np.array([[x, y], [x + 0.3, y], [x + 0.3, y + 0.3]])

    moved = adapt(goals, square, roster, (body,))

    assert moved is not None
    steps = np.linalg.norm(moved.positions - goals.positions, axis=1)
    assert np.flatnonzero(steps).tolist() == [4]
    assert steps[4] <= 0.3 + 0.2 + 0.02
    np.testing.assert_array_equal(moved.types, goals.types)


def test_goals_of_a_slightly_smaller_shape_follow_it() -> None:
    contour = load_shape("formation_3", scale=1.1)
    goals = partition(contour, FIELD, config=BRIEF)
    center = contour.mean(axis=0)
    shrunk = center + 0.99 * (contour - center)

    moved = adapt(goals, shrunk, FIELD)

    assert moved is not None
    assert np.linalg.norm(moved.positions - goals.positions, axis=1).max() < 0.5
    assert all(Polygon(shrunk).contains(Point(p)) for p in moved.positions)


def test_goals_for_which_there_is_no_room_are_not_adapted() -> None:
    square = np.array([[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0]])
    roster = Roster.of([THESIS_TYPES[1]] * 9)
    goals = partition(square, roster, config=BRIEF)

    assert adapt(goals, square / 4.0, roster) is None
    assert adapt(goals, square / 20.0, roster) is None


def test_what_is_forgotten_is_found_anew_and_is_the_same() -> None:
    contour = load_shape("formation_1")
    kept = partition(contour, FIELD)
    assert partition(contour, FIELD) is kept

    forget()

    found = partition(contour, FIELD)
    assert found is not kept
    assert found.positions.tobytes() == kept.positions.tobytes()
