import numpy as np
import pytest

from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.roster import Roster, TypeGroup


def test_a_roster_counts_the_robots_of_each_type() -> None:
    small, middle, large = THESIS_TYPES

    roster = Roster.of([large, small, middle, small])

    assert [(group.type, group.count, group.coverage_radius_m) for group in roster.groups] == [
        (1, 2, 0.15),
        (2, 1, 0.3),
        (3, 1, 0.5),
    ]
    assert roster.size == 4


def test_types_are_spread_evenly_over_the_sequence() -> None:
    roster = Roster.of([THESIS_TYPES[0]] * 8 + [THESIS_TYPES[2]] * 4)

    types = roster.interleaved_types()

    # Every third robot is large, so any three in a row hold exactly one.
    assert [int((types[k : k + 3] == 3).sum()) for k in range(0, 12, 3)] == [1, 1, 1, 1]
    assert (types == 1).sum() == 8


def test_radii_follow_the_types() -> None:
    roster = Roster.of(THESIS_TYPES)

    assert roster.radii_of(np.array([3, 1])).tolist() == [0.5, 0.15]


def test_a_roster_without_some_robots_has_the_rest_of_each_type() -> None:
    small, middle, large = THESIS_TYPES
    roster = Roster.of([small, small, middle, large])

    assert roster.without([1, 2, 2]) == Roster.of([small, large])
    assert roster.without([]) == roster
    with pytest.raises(ConfigError, match="no robot is left"):
        roster.without([1, 1, 2, 3])


def test_a_type_named_twice_is_refused() -> None:
    group = TypeGroup(type=2, count=1, coverage_radius_m=0.3)

    with pytest.raises(ConfigError, match="type 2 2 times; merge"):
        Roster(groups=(group, group))


def test_a_roster_without_robots_is_refused() -> None:
    with pytest.raises(ConfigError, match="no robots"):
        Roster.of([])
