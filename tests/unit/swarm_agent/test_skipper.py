"""A boat that follows timed guideposts in continuous space."""

import numpy as np
import pytest
from assembly_problems import ALL_SIDES, problem_of

from swarm_agent.assembly.boat_computer import BoatComputer
from swarm_agent.assembly.steering import SkipperConfig, SkipperInputs, SkipperOutputs, grid_faces
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.assembly.orders import Order, TimedOrders
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, TimedPaths, TreeNode
from swarm_msgs_py.assembly.progress_frames import NO_DEPARTURE, ProgressFrame

PERIOD_S = 0.25
CONFIG = SkipperConfig()
PROBLEM = problem_of([(10, 10), (11, 10)], [ALL_SIDES] * 2, starts=[(8, 10), (12, 10)])
TREE = AssemblyTree((TreeNode((0, 1), -1, (1, 2), Axis.X, 10), TreeNode((0,), 0), TreeNode((1,), 0)))
PATHS = TimedPaths(np.array([[(8, 10), (12, 10)], [(9, 10), (12, 10)], [(10, 10), (11, 10)]]))
ORDER = Order(1, TimedOrders(PROBLEM, Dispatch((0, 1), (0, 1)), TREE, PATHS, 1))


class Driver:
    """One boat whose reference is its pose: a perfect vehicle."""

    def __init__(self, boat: int) -> None:
        self.computer = BoatComputer(boat, CONFIG, PERIOD_S)
        self.pose = np.array([*(0.25 * np.array(PROBLEM.starts[boat])), 0.0])
        self.tick = 0

    def step(
        self, *frames: ProgressFrame, order: Order | None = ORDER, contacts: frozenset[Face] = frozenset()
    ) -> SkipperOutputs:
        inputs = SkipperInputs(self.tick, self.pose.copy(), self.pose.copy(), contacts, frames)
        said = self.computer.step(inputs, order)
        self.pose = self.pose + PERIOD_S * said.velocity
        self.tick += 1
        return said


def test_a_boat_on_its_own_leaves_at_once_and_keeps_its_speed() -> None:
    driver = Driver(0)
    said = [driver.step() for _ in range(7)]

    speeds = [np.hypot(*one.velocity[:2]) for one in said]
    assert max(speeds) == pytest.approx(CONFIG.cruise_mps)
    assert driver.pose[0] == pytest.approx(2.25)


def test_a_boat_turns_to_the_orientation_of_its_dispatch_before_it_leaves() -> None:
    driver = Driver(1)
    for _ in range(20):
        driver.step()

    assert driver.pose[2] == pytest.approx(-np.pi / 2.0)
    assert driver.pose[0] == pytest.approx(3.0)


def test_partners_wait_for_each_other_before_they_dock_and_come_in_slowly() -> None:
    driver = Driver(0)
    for _ in range(30):
        said = driver.step(ProgressFrame(1, 1, 0))
    assert (said.frame.steps_done, driver.pose[0]) == (1, pytest.approx(2.25))

    speeds = [np.hypot(*driver.step(ProgressFrame(1, 1, 1)).velocity[:2]) for _ in range(12)]

    assert speeds[0] == pytest.approx(CONFIG.cruise_mps)
    assert speeds[5] == pytest.approx(CONFIG.docking_mps)
    assert driver.pose[0] == pytest.approx(2.5)


def test_a_group_is_done_only_when_a_foil_says_that_it_holds() -> None:
    driver = Driver(0)
    for _ in range(40):
        said = driver.step(ProgressFrame(1, 1, 1))
    assert said.frame.steps_done == 2
    assert not said.is_done

    assert driver.step(ProgressFrame(1, 1, 2), contacts=frozenset({Face.RIGHT})).is_done


def test_a_dock_that_does_not_hold_makes_the_boat_say_that_it_is_stuck() -> None:
    driver = Driver(0)
    said = [driver.step(ProgressFrame(1, 1, 1)) for _ in range(110)]

    assert not said[60].frame.is_stuck
    assert said[-1].frame.is_stuck


def test_a_stop_lets_a_boat_reach_its_next_cell_and_no_further() -> None:
    driver = Driver(0)
    driver.step()
    for _ in range(30):
        said = driver.step(ProgressFrame(1, 1, 1), order=Order(1, None))

    assert said.frame.is_halted
    assert said.frame.departure_tick == NO_DEPARTURE
    assert driver.pose[0] == pytest.approx(2.25)


def test_a_boat_without_a_target_stays_and_says_so() -> None:
    computer = BoatComputer(5, CONFIG, PERIOD_S)
    pose = np.zeros(3)
    said = computer.step(SkipperInputs(0, pose, pose, frozenset(), ()), ORDER)

    assert not said.velocity.any()
    assert (said.frame.boat, said.frame.epoch) == (5, 1)


@pytest.mark.parametrize(("heading", "side"), [(0.0, Face.UP), (-np.pi / 2, Face.RIGHT), (3.1, Face.DOWN)])
def test_foils_are_told_in_the_frame_of_the_grid(heading: float, side: Face) -> None:
    assert grid_faces(frozenset({Face.UP}), heading) == {side}
