import pytest

from swarm_msgs_py.assembly.faces import Face, Gender, distinct_turns, layout_class, turned


def test_a_clockwise_quarter_turn_brings_the_left_side_up() -> None:
    assert turned((1, 2, 3, 4), 1) == (3, 4, 2, 1)  # up = left, down = right, left = down, right = up


def test_four_quarter_turns_change_nothing() -> None:
    assert turned((1, 0, 2, 0), 4) == (1, 0, 2, 0)


@pytest.mark.parametrize(
    ("layout", "states"),
    [((1, 0, 0, 0), 4), ((1, 0, 0, 1), 4), ((1, 1, 0, 0), 2), ((1, 1, 1, 0), 4), ((1, 1, 1, 1), 1), ((1, 2, 0, 0), 4)],
)
def test_a_layout_has_as_many_orientations_as_its_symmetry_allows(layout: tuple[int, ...], states: int) -> None:
    up, down, left, right = layout

    assert len(distinct_turns((up, down, left, right))) == states


def test_genderless_masks_fall_into_six_classes() -> None:
    masks = [(a, b, c, d) for a in (0, 1) for b in (0, 1) for c in (0, 1) for d in (0, 1)]

    assert len({layout_class(mask) for mask in masks}) == 6


def test_opposite_genders_join_and_equal_ones_do_not() -> None:
    assert Gender.OPPOSITE.joins(1, 2)
    assert Gender.OPPOSITE.joins(2, 1)
    assert not Gender.OPPOSITE.joins(1, 1)
    assert not Gender.OPPOSITE.joins(2, 2)
    assert not Gender.OPPOSITE.joins(0, 2)
    assert Gender.GENDERLESS.joins(1, 1)
    assert not Gender.GENDERLESS.joins(0, 1)


def test_every_side_meets_the_opposite_one() -> None:
    for face in Face:
        (dx, dy), (u, v) = face.offset, face.opposite.offset
        assert (dx + u, dy + v) == (0, 0)
