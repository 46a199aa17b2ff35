"""When a blocked robot offers to exchange goals, and what it says in the offer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import PERIOD, make_plan, make_presence
from numpy.testing import assert_array_equal

from swarm_agent.decision.config import DecisionConfig, SwapConfig
from swarm_agent.decision.consensus import Consensus
from swarm_agent.decision.path_costs import PathCosts
from swarm_agent.decision.swapping import DOUBLINGS_MAX, SwapOffers
from swarm_agent.planning.config import PlanningConfig
from swarm_msgs_py.messages.bodies import WEIGHT_ONE, CostRow
from swarm_msgs_py.messages.radio import Presence
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.networking.mesh import MeshNetwork
from swarm_msgs_py.robots import THESIS_TYPES
from swarm_msgs_py.types import IntArray, NodeId

ME, OTHER = NodeId(1), NodeId(2)
HERE = np.zeros(2)
CONFIG = SwapConfig()
AFTER = round((CONFIG.after_s or 0.0) / PERIOD)
WORTH = round(100 * CONFIG.worth_m)
AHEAD, BEHIND, FARTHER = [5.0, 0.0], [-5.0, 0.0], [9.0, 0.0]


class Mesh(MeshNetwork):
    """A radio that hears what a test says."""

    def __init__(self, heard: dict[NodeId, Presence]) -> None:
        super().__init__(ME, NetworkConfig(), PERIOD)
        self.heard = heard

    @property
    def neighbors(self) -> dict[NodeId, Presence]:
        return self.heard


class Blocked:
    """Robot 1 in the origin with a goal ahead, robot 2 in front of it with another goal."""

    def __init__(
        self,
        other: Presence | None = None,
        goals: tuple[list[float], ...] = (AHEAD, BEHIND, FARTHER),
        config: SwapConfig = CONFIG,
        weights: tuple[int, int] = (WEIGHT_ONE, WEIGHT_ONE),
    ) -> None:
        self.plan = make_plan(np.array(goals))
        consensus = Consensus(ME, 1, DecisionConfig(), PERIOD)
        self.book = consensus.book
        self.book.adopt(self.plan)
        for robot, weight in zip((ME, OTHER), weights, strict=True):
            consensus.book.put(CostRow(1, robot, 1, 1, np.zeros(len(goals), dtype=np.int64), weight))
        self.mesh = Mesh({OTHER: other if other is not None else at(0.6)})
        paths = PathCosts(THESIS_TYPES[0], PlanningConfig())
        self._swaps = SwapOffers(ME, config, paths, self.mesh, consensus, PERIOD)

    def tick(self, taken: dict[NodeId, int] | None = None, is_blocked: bool = True) -> IntArray | None:
        taken = {ME: 0, OTHER: 1} if taken is None else taken
        return self._swaps.step(0, self.plan, HERE, taken, is_blocked=is_blocked)

    def offers(self, ticks: int, **said: object) -> dict[int, IntArray]:
        """Return what is offered in which of the next ticks."""
        said_by_tick = {tick: self.tick(**said) for tick in range(1, ticks + 1)}  # type: ignore[arg-type]
        return {tick: surcharge for tick, surcharge in said_by_tick.items() if surcharge is not None}


def at(x: float, y: float = 0.0, **changes: object) -> Presence:
    return make_presence(x, y, epoch=1, **changes)


def test_who_is_blocked_for_long_makes_the_goals_behind_the_other_dearer() -> None:
    offers = Blocked().offers(AFTER)

    assert list(offers) == [AFTER]
    assert_array_equal(offers[AFTER], [WORTH, 0, WORTH])


def test_the_goal_of_the_robot_in_the_way_is_not_dearer_though_it_stands_on_it() -> None:
    offers = Blocked(at(0.6), goals=([5.0, 0.0], [0.6, 0.0])).offers(AFTER)

    assert_array_equal(offers[AFTER], [WORTH, 0])


def test_who_gets_on_now_and_then_offers_later() -> None:
    swaps = Blocked()
    swaps.offers(AFTER - 1)

    assert swaps.tick(is_blocked=False) is None
    assert list(swaps.offers(AFTER)) == [2]


def test_each_attempt_waits_twice_as_long_as_the_last_and_is_worth_twice_as_much() -> None:
    offers = Blocked().offers(AFTER * (1 + 2 + 4))

    assert list(offers) == [AFTER, 3 * AFTER, 7 * AFTER]
    assert [int(surcharge[0]) for surcharge in offers.values()] == [WORTH, 2 * WORTH, 4 * WORTH]


def test_attempts_do_not_grow_without_end() -> None:
    largest = 2**DOUBLINGS_MAX
    offers = Blocked().offers(AFTER * 5 * largest)

    assert max(int(surcharge[0]) for surcharge in offers.values()) == largest * WORTH
    assert len(offers) > DOUBLINGS_MAX + 1


def test_a_new_plan_begins_anew() -> None:
    swaps = Blocked()
    swaps.offers(AFTER)
    swaps.plan = replace(swaps.plan, epoch=2)
    swaps.book.adopt(swaps.plan)
    swaps.book.put(CostRow(2, ME, 1, 1, np.zeros(3, dtype=np.int64)))
    swaps.book.put(CostRow(2, OTHER, 1, 1, np.zeros(3, dtype=np.int64)))
    swaps.mesh.heard[OTHER] = replace(at(0.6), epoch=2)

    assert list(swaps.offers(AFTER)) == [AFTER]


@pytest.mark.parametrize(
    "other",
    [
        at(0.6, robot_type=2),
        replace(at(0.6), epoch=0),
        at(CONFIG.distance_m + 0.1),
        at(-0.6),
        at(0.0, 1.2),
    ],
    ids=["another type", "another plan", "far", "behind", "beside the way"],
)
def test_no_offer_is_made_for_a_robot_that_is_not_in_the_way_or_cannot_exchange(other: Presence) -> None:
    assert Blocked(other).offers(3 * AFTER) == {}


@pytest.mark.parametrize("taken", [{OTHER: 1}, {ME: 0}], ids=["own", "other"])
def test_no_offer_is_made_without_two_goals(taken: dict[NodeId, int]) -> None:
    assert Blocked().offers(3 * AFTER, taken=taken) == {}


def test_swaps_can_be_turned_off() -> None:
    assert Blocked(config=SwapConfig(after_s=None)).offers(10 * AFTER) == {}


def test_a_dear_exchange_is_offered_once_the_wait_has_become_long() -> None:
    # The other stands at its goal, mine is 6 m behind it. After the exchange it drives these 6 m, of which each counts
    # twice, and I drive 0.6 m instead of 6.6 m: 6 m more in all. The attempts are worth 2 m, 4 m and 8 m.
    swaps = Blocked(at(0.6), goals=([6.6, 0.0], [0.6, 0.0]), weights=(WEIGHT_ONE, 2 * WEIGHT_ONE))

    offers = swaps.offers(7 * AFTER)

    assert list(offers) == [7 * AFTER]
    assert_array_equal(offers[7 * AFTER], [4 * WORTH, 0])
