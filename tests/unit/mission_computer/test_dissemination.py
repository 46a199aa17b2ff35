import pytest

from mission_computer.config import MissionConfig
from mission_computer.dissemination import Dissemination
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import NodeId

R0, R1 = NodeId(0), NodeId(1)


@pytest.fixture
def dissemination() -> Dissemination:
    config = MissionConfig(repeat_first_s=2.0, repeat_growth=2.0, repeat_longest_s=6.0)
    dissemination = Dissemination(config)
    dissemination.restart(epoch=1, time=0.0)
    return dissemination


def flood_times(dissemination: Dissemination, reachable: list[NodeId], until: float, since: float = 0.0) -> list[float]:
    ticks = [since + 0.5 * k for k in range(int((until - since) / 0.5))]
    return [time for time in ticks if dissemination.is_due(time, reachable)]


def test_a_new_plan_is_flooded_at_once_even_if_nobody_is_known(dissemination: Dissemination) -> None:
    assert flood_times(dissemination, [], until=30.0) == [0.0]


def test_floods_repeat_with_growing_pauses_while_a_robot_has_not_acknowledged(dissemination: Dissemination) -> None:
    dissemination.acknowledge(R0, 1)

    # Pauses 2, 4, then 6 s at most.
    assert flood_times(dissemination, [R0, R1], until=24.0) == [0.0, 2.0, 6.0, 12.0, 18.0]


def test_floods_end_when_every_reachable_robot_has_acknowledged(dissemination: Dissemination) -> None:
    flood_times(dissemination, [R0, R1], until=3.0)
    dissemination.acknowledge(R0, 1)
    dissemination.acknowledge(R1, 1)

    assert flood_times(dissemination, [R0, R1], until=60.0, since=3.0) == []
    assert dissemination.informed == (R0, R1)


def test_a_robot_that_comes_into_reach_later_is_told(dissemination: Dissemination) -> None:
    flood_times(dissemination, [], until=20.0)

    assert flood_times(dissemination, [R0], until=20.5, since=20.0) == [20.0]


def test_acknowledgements_of_an_older_plan_do_not_count(dissemination: Dissemination) -> None:
    dissemination.acknowledge(R0, 1)
    dissemination.restart(epoch=2, time=10.0)
    dissemination.acknowledge(R0, 1)

    assert dissemination.informed == ()


def test_a_robot_that_forgot_the_plan_is_told_again(dissemination: Dissemination) -> None:
    flood_times(dissemination, [R0], until=1.0)
    dissemination.acknowledge(R0, 1)
    dissemination.acknowledge(R0, 0)

    assert flood_times(dissemination, [R0], until=4.0, since=1.0) == [2.0]


def test_a_longest_pause_below_the_first_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"repeat_longest_s must be >= repeat_first_s .5 s., got 1"):
        MissionConfig(repeat_longest_s=1.0)


def test_a_plan_is_on_its_way_until_the_first_pause_is_over(dissemination: Dissemination) -> None:
    before = dissemination.is_on_its_way(0.0)
    dissemination.is_due(0.0, [R0])

    assert [before, dissemination.is_on_its_way(1.5), dissemination.is_on_its_way(2.0)] == [False, True, False]
