from swarm_agent.assembly.group_path import group_path, too_near

GRID = ((1, 1), (12, 12))
PAIR = [(3, 3), (4, 3)]


def test_a_free_group_takes_a_straight_way() -> None:
    path = group_path(PAIR, (0, 0), [(4, 0)], GRID, set())

    assert path == [(1, 0), (2, 0), (3, 0), (4, 0)]


def test_a_group_goes_around_an_obstacle_with_all_its_boats() -> None:
    forbidden = too_near([(7, 3)])

    path = group_path(PAIR, (0, 0), [(6, 0)], GRID, forbidden)

    assert path is not None
    assert path[-1] == (6, 0)
    assert all((x + dx, y + dy) not in forbidden for dx, dy in path for x, y in PAIR)


def test_a_group_at_its_goal_has_no_way_to_go() -> None:
    assert group_path(PAIR, (2, 2), [(2, 2)], GRID, set()) == []


def test_no_way_leads_through_a_wall() -> None:
    wall = {(7, y) for y in range(1, 13)}

    assert group_path(PAIR, (0, 0), [(6, 0)], GRID, wall) is None


def test_no_boat_of_a_group_leaves_the_grid() -> None:
    assert group_path(PAIR, (0, 0), [(9, 0)], GRID, set()) is None  # the right boat would be at x = 13


def test_the_nearest_of_several_goals_is_taken() -> None:
    path = group_path(PAIR, (0, 0), [(5, 5), (0, 2)], GRID, set())

    assert path is not None
    assert path[-1] == (0, 2)
