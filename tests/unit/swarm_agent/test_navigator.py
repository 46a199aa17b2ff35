"""Boats in continuous space that find their ways by themselves, in slots of the common clock."""

import numpy as np
from assembly_problems import ALL_SIDES, problem_of

from swarm_agent.assembly.boat_computer import BoatComputer
from swarm_agent.assembly.navigator import slot_ticks
from swarm_agent.assembly.steering import SkipperConfig, SkipperInputs
from swarm_msgs_py.assembly.boat_frames import BoatFrame, Phase
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.assembly.orders import GuidedOrders, Order
from swarm_msgs_py.assembly.plan import AssemblyTree, Axis, Dispatch, Guideposts, TreeNode
from swarm_msgs_py.assembly.progress_frames import ProgressFrame

PERIOD_S, CELL_M = 0.25, 0.25
CONFIG = SkipperConfig()
SLOT = slot_ticks(CONFIG, PERIOD_S)
# Boats 0 and 1 join first, 0 drives; then both of them are visited by 2.
PROBLEM = problem_of([(12, 12), (13, 12), (14, 12)], [ALL_SIDES] * 3, starts=[(9, 12), (13, 12), (17, 10)])
TREE = AssemblyTree(
    (
        TreeNode((0, 1, 2), -1, (1, 2), Axis.X, 13),
        TreeNode((0, 1), 0, (3, 4), Axis.X, 12),
        TreeNode((2,), 0),
        TreeNode((0,), 1),
        TreeNode((1,), 1),
    )
)
POSTS = Guideposts(((0, 0), (0, 0), (3, 0), (-3, 0), (0, 0)))
ORDER = Order(1, GuidedOrders(PROBLEM, Dispatch((0, 1, 2), (0, 0, 0)), TREE, POSTS, 1))


class Basin:
    """Three boats that are always where their firmware is told, with a radio that may lose what `hears` refuses."""

    def __init__(self, *, foils_work: bool = True) -> None:
        self.computers = [BoatComputer(boat, CONFIG, PERIOD_S) for boat in range(3)]
        self.poses = np.column_stack([CELL_M * np.array(PROBLEM.starts), np.zeros(3)])
        self.frames: list[ProgressFrame] = []
        self.words: list[BoatFrame] = []
        self.said: list[BoatFrame] = []
        self.done = [False] * 3
        self.tick = 0
        self._foils_work = foils_work

    def cells(self) -> list[tuple[int, int]]:
        return [(round(x / CELL_M), round(y / CELL_M)) for x, y, _ in self.poses]

    def run(self, ticks: int, hears=lambda _boat, _word, _tick: True) -> None:
        for _ in range(ticks):
            outputs = [
                computer.step(
                    SkipperInputs(
                        self.tick,
                        self.poses[boat].copy(),
                        self.poses[boat].copy(),
                        self._contacts(boat),
                        [frame for frame in self.frames if frame.boat != boat],
                        [word for word in self.words if word.boat != boat and hears(boat, word, self.tick)],
                        [tuple(pose[:2]) for other, pose in enumerate(self.poses) if other != boat],
                    ),
                    ORDER,
                )
                for boat, computer in enumerate(self.computers)
            ]
            self.poses += PERIOD_S * np.array([said.velocity for said in outputs])
            self.frames = [said.frame for said in outputs]
            self.words = [said.word for said in outputs if said.word is not None]
            self.said += self.words
            self.done = [said.is_done for said in outputs]
            self.tick += 1

    def _contacts(self, boat: int) -> frozenset[Face]:
        if not self._foils_work:
            return frozenset()
        gaps = np.delete(self.poses, boat, axis=0)[:, :2] - self.poses[boat, :2]
        return frozenset(f for f in Face if (np.abs(gaps - CELL_M * np.array(f.offset)).max(axis=1) < 1e-6).any())


def test_boats_find_their_ways_and_know_when_they_are_done() -> None:
    basin = Basin()

    basin.run(8 * SLOT)

    assert basin.cells() == list(PROBLEM.targets)
    assert basin.done == [True] * 3


def test_a_group_moves_one_cell_in_a_slot_and_rests_before_the_next() -> None:
    basin = Basin()
    for _ in range(6):
        before = basin.cells()
        basin.run(SLOT)
        assert max(abs(x - u) + abs(y - v) for (x, y), (u, v) in zip(before, basin.cells(), strict=True)) <= 1
        assert np.abs(basin.poses[:, :2] / CELL_M - np.round(basin.poses[:, :2] / CELL_M)).max() < 1e-9


def test_every_second_frame_lost_costs_nothing() -> None:
    basin = Basin()

    basin.run(8 * SLOT, lambda boat, word, tick: (boat + word.boat + tick) % 2 == 0)

    assert basin.cells() == list(PROBLEM.targets)


def test_nobody_who_hears_nothing_comes_near_anybody() -> None:
    basin = Basin()

    basin.run(8 * SLOT, lambda *_: False)

    cells = basin.cells()
    assert min(max(abs(x - u), abs(y - v)) for i, (x, y) in enumerate(cells) for u, v in cells[:i]) >= 2


def test_a_group_that_its_foils_do_not_confirm_leaves_no_more_and_says_so() -> None:
    basin = Basin(foils_work=False)

    basin.run(5 * SLOT)
    met = basin.cells()[:2]
    basin.run(4 * SLOT)

    assert met == list(PROBLEM.targets[:2])
    assert basin.cells()[:2] == met
    assert any(frame.is_stuck for frame in basin.frames)


def test_only_leaders_say_what_a_group_does() -> None:
    basin = Basin()

    basin.run(8 * SLOT)

    late = [word for word in basin.said if word.step >= 7 and word.phase is Phase.GO]
    assert {word.boat for word in late} == {0}


def test_a_stop_holds_a_boat_where_it_is() -> None:
    basin = Basin()
    basin.run(SLOT + SLOT // 2)
    for computer in basin.computers:
        computer.step(SkipperInputs(basin.tick, basin.poses[0], basin.poses[0], frozenset(), []), Order(1, None))
    basin.run(SLOT)
    stood = basin.cells()
    basin.run(2 * SLOT + SLOT // 2)

    assert basin.cells() == stood
    assert all(frame.is_halted for frame in basin.frames)
