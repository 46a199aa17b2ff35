"""Goals go to the types whose robots are nearest, where these fit."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from mission_computer.config import MissionConfig
from mission_computer.membership import Member
from mission_computer.mission import Mission
from mission_computer.nearest_types import distance_to_go, nearest_types
from mission_computer.plan_making import PlanMaker
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.networking.config import NetworkConfig
from swarm_msgs_py.partition import GoalSet, PartitionConfig
from swarm_msgs_py.partition.config import Gaps
from swarm_msgs_py.roster import Roster, TypeGroup
from swarm_msgs_py.step_io import MissionInputs
from swarm_msgs_py.types import FloatArray, NodeId

TYPES = (1, 2, 2, 3, 3)
ROSTER = Roster(
    groups=tuple(
        TypeGroup(type=kind, count=count, coverage_radius_m=radius)
        for kind, count, radius in ((1, 1, 0.16), (2, 2, 0.11), (3, 2, 0.08))
    )
)
SQUARE = 0.5 * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
GAPS = PartitionConfig(gaps=Gaps(robot_m=0.05, contour_m=0.02, obstacle_m=0.02))


def members(places: FloatArray, types: tuple[int, ...] = TYPES) -> tuple[Member, ...]:
    return tuple(
        Member(NodeId(number), kind, (float(x), float(y)), 0, -1, 0.0)
        for number, (kind, (x, y)) in enumerate(zip(types, places, strict=True))
    )


def shortest(places: FloatArray, goals: FloatArray) -> float:
    """Return the least sum of beelines over all ways to share out goals, by trying every one."""
    ways = np.linalg.norm(places[:, None] - goals[None], axis=2)
    return min(float(ways[range(len(goals)), list(order)].sum()) for order in permutations(range(len(goals))))


@pytest.mark.parametrize("seed", range(5))
def test_the_ways_are_as_short_as_any_choice_of_types_makes_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    places, goals = rng.uniform(-1.0, 1.0, (2, 5, 2))
    robots = members(places)
    types = nearest_types(GoalSet(goals, np.array(TYPES)), robots)

    assert types is not None
    assert sorted(types.tolist()) == sorted(TYPES)
    assert distance_to_go(GoalSet(goals, types), robots) == pytest.approx(shortest(places, goals))


def test_goals_for_other_robots_than_these_stay_as_they_are() -> None:
    goals = GoalSet(np.zeros((5, 2)), np.array(TYPES))
    somebody_lost = members(np.zeros((5, 2)))[:4]
    nowhere = (*somebody_lost, Member(NodeId(4), 3, None, 0, -1, 0.0))

    assert nearest_types(goals, somebody_lost) is None
    assert nearest_types(goals, nowhere) is None


@pytest.mark.parametrize("seed", range(3))
def test_plans_for_robots_nearby_are_sound_and_never_worse(seed: int) -> None:
    places = np.random.default_rng(seed).uniform(-0.8, 0.8, (5, 2))
    maker = PlanMaker(GAPS, ROSTER, (), None)

    plain = maker.for_shape(1, SQUARE, ())
    near = maker.for_shape(2, SQUARE, (), members(places))

    def to_go(plan: Plan) -> float:
        return distance_to_go(GoalSet(plan.goals, plan.goal_types), members(places))

    assert to_go(near) <= to_go(plain) + 1e-9
    radii = ROSTER.radii_of(near.goal_types)
    assert (np.abs(near.goals).max(axis=1) <= 0.5 - radii - 0.02 + 1e-6).all()
    for one in range(5):
        for other in range(one):
            gap = np.hypot(*(near.goals[one] - near.goals[other])) - radii[one] - radii[other]
            assert gap >= 0.05 - 1e-6


def test_the_first_plan_waits_for_robots_to_say_where_they_are_but_not_for_ever() -> None:
    config = MissionConfig(nearest_types=True, nearest_wait_s=1.0, partition=GAPS)
    mission = Mission(config, NetworkConfig(), ROSTER, (), SQUARE, 0.1)

    planned = [mission.step(MissionInputs(tick, tick * 0.1, ())).plan is not None for tick in range(12)]

    assert planned == [tick == 10 for tick in range(12)]
