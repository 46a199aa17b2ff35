from mission_computer.assembly.dock_faults import broken_sides
from swarm_msgs_py.assembly.faces import Face

ONE, OTHER, THIRD = (1, Face.UP), (4, Face.DOWN), (7, Face.LEFT)


def test_a_side_that_has_held_is_not_blamed_for_a_dock_that_failed() -> None:
    assert broken_sides([(ONE, OTHER)], {OTHER}) == {ONE}
    assert broken_sides([(ONE, OTHER)], {ONE}) == {OTHER}


def test_a_boat_that_is_docked_elsewhere_is_trusted_before_one_that_never_docked() -> None:
    assert broken_sides([(ONE, OTHER)], {(4, Face.LEFT)}) == {ONE}


def test_a_boat_that_failed_with_two_others_clears_both() -> None:
    first = broken_sides([(ONE, OTHER)], set())
    both = broken_sides([(ONE, OTHER), (ONE, THIRD)], set())

    assert first == {OTHER}
    assert both == {ONE}


def test_a_dock_that_held_once_and_failed_since_has_somebody_to_blame() -> None:
    assert broken_sides([(ONE, OTHER)], {ONE, OTHER})


def test_nothing_failed_nobody_is_blamed() -> None:
    assert broken_sides([], {ONE}) == frozenset()
