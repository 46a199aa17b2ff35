"""A boat in continuous space that finds its way by itself: the steps of the grid, in slots of the common clock.

A slot is one step of the published method. First every boat tells where it is and what it sees, then leaders tell what
they want, then leaders tell what they do, and their groups drive to the next cells. Everything is said several times,
so that a lost frame costs nothing; who has missed all of them stays, which the rules of the pilot allow at any time. A
group does not leave before its contact foils say that it holds together.
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from swarm_agent.assembly.boat import Boat, BoatInputs
from swarm_agent.assembly.crew import Orders
from swarm_agent.assembly.crew_contacts import CrewContacts
from swarm_agent.assembly.pilot import PilotConfig
from swarm_agent.assembly.steering import (
    SkipperConfig,
    SkipperInputs,
    SkipperOutputs,
    cell_at,
    grid_faces,
    has_arrived,
    start_heading,
    steered,
)
from swarm_msgs_py.assembly.boat_frames import BoatFrame, Move, Phase
from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.orders import GuidedOrders
from swarm_msgs_py.assembly.problem import chebyshev
from swarm_msgs_py.assembly.progress_frames import ProgressFrame
from swarm_msgs_py.types import FloatArray


class Navigator:
    """One boat with a target.

    Parameters
    ----------
    boat : int
    orders : GuidedOrders
    config : SkipperConfig
    period_s : float
        Control period [s].
    heading : float
        Of the boat when it gets the orders [rad].
    """

    def __init__(self, boat: int, orders: GuidedOrders, config: SkipperConfig, period_s: float, heading: float) -> None:
        self._boat = boat
        self._config = config
        self._period_s = period_s
        self._epoch = orders.epoch
        self._orders = Orders(orders.problem, orders.dispatch, orders.tree, orders.guideposts)
        self._pilot_config = PilotConfig()
        self._mind = Boat(boat, self._orders, self._pilot_config)
        self._holds = CrewContacts(orders.problem, orders.dispatch)
        self._heading = start_heading(heading, orders.dispatch.turns[orders.dispatch.boats.index(boat)])
        self._node = orders.tree.leaf_of()[orders.dispatch.boats.index(boat)]
        self._goal: Cell = orders.problem.starts[boat]
        self._here: Cell = self._goal
        self._seen: tuple[Cell, ...] = ()
        self._slot = -1  # the one that it takes part in
        self._heard: list[BoatFrame] = []  # in this slot
        self._word: BoatFrame | None = None
        self._moves = False
        self._is_docking = False
        self._told: dict[int, ProgressFrame] = {}
        self._apart_since: int | None = None
        self.is_halting = False
        self.steps_done = 0

    @property
    def steps(self) -> int:
        """Steps so far: nobody knows how many there will be."""
        return self.steps_done

    def step(self, inputs: SkipperInputs) -> SkipperOutputs:
        """Act in one tick."""
        self._told |= {frame.boat: frame for frame in inputs.frames if frame.epoch == self._epoch}
        slot, offset = divmod(inputs.tick, slot_ticks(self._config, self._period_s))
        self._heard += inputs.words
        holds = self._crew_holds(inputs)
        if offset == 0:
            self._begin(slot, inputs)
        elif slot == self._slot:
            self._continue(offset, may_leave=holds and self._has_arrived(inputs))
        target = self._target()
        velocity = steered(self._config, target, inputs.reference, self._period_s, is_docking=self._is_docking)
        talk = self._config.talk_ticks
        frame = ProgressFrame(
            self._boat,
            self._epoch,
            self.steps_done & 0xFFFF,
            contacts=grid_faces(inputs.contacts, inputs.pose[2]),
            is_halted=self.is_halting and not self._moves and offset > 2 * talk and self._has_arrived(inputs),
            is_stuck=self._is_stuck(inputs, holds),
        )
        word = self._word if slot == self._slot else None
        return SkipperOutputs(velocity, frame, self._node == 0 and holds, target[:2], word)

    def _begin(self, slot: int, inputs: SkipperInputs) -> None:
        """Find out where everybody is, and say so."""
        self.steps_done += self._node != 0
        self._slot, self._heard, self._moves = slot, [], False
        self._here = cell_at(self._config, inputs.pose)
        radius = self._pilot_config.perception_radius_cells
        cells = {cell_at(self._config, np.array(place)) for place in inputs.seen}
        self._seen = tuple(sorted(cell for cell in cells if 0 < chebyshev(cell, self._here) <= radius))
        self._word = self._think(Phase.LOOK)[0]

    def _continue(self, offset: int, *, may_leave: bool) -> None:
        talk = self._config.talk_ticks
        if offset == talk:
            self._word = self._think(Phase.CLAIM)[0]
        elif offset == 2 * talk:
            claim = self._word
            _, move = self._think(Phase.GO)
            if claim is None or self.is_halting or not may_leave:
                move = Move.STAY
            self._word = replace(claim, phase=Phase.GO, move=move) if claim is not None else None
        elif offset > 2 * talk and not self._moves:
            self._obey_leader()

    def _think(self, phase: Phase) -> tuple[BoatFrame | None, Move]:
        said = self._mind.step(BoatInputs(self._slot, phase, self._here, self._seen, self._heard))
        self._node = said.node
        return said.frame, said.move

    def _obey_leader(self) -> None:
        """Drive on when the leader says so, which may be this boat."""
        leader = self._orders.leader(self._node)
        words = [self._word] if self._word is not None else self._heard
        for word in words:
            if word.phase is Phase.GO and word.boat == leader and word.node == self._node and self._is_now(word):
                x, y = self._orders.problem.targets[self._orders.dispatch.boats.index(self._boat)]
                dx, dy = word.move.offset
                # Counted from where the leader says that the group is: who missed a step catches up.
                self._goal = (x + word.shift[0] + dx, y + word.shift[1] + dy)
                self._moves = word.move is not Move.STAY
                self._is_docking = word.is_docking

    def _is_now(self, word: BoatFrame) -> bool:
        return word.step == self._slot & 0xFFFF

    def _target(self) -> FloatArray:
        x, y = self._goal
        return np.array([self._config.cell_m * x, self._config.cell_m * y, self._heading])

    def _has_arrived(self, inputs: SkipperInputs) -> bool:
        return has_arrived(self._config, self._target(), inputs)

    def _crew_holds(self, inputs: SkipperInputs) -> bool:
        told = {boat: frame.contacts for boat, frame in self._told.items()}
        own = {self._boat: grid_faces(inputs.contacts, inputs.pose[2])}
        return self._holds.is_connected(self._orders.crew(self._node), told | own)

    def _is_stuck(self, inputs: SkipperInputs, holds: bool) -> bool:
        """Return whether the group has met its partner long ago, and does not hold together."""
        if holds:
            self._apart_since = None
            return False
        if self._apart_since is None:
            self._apart_since = inputs.tick
        return (inputs.tick - self._apart_since) * self._period_s > self._config.docking_patience_s


def slot_ticks(config: SkipperConfig, period_s: float) -> int:
    """Return the ticks of one step: two rounds of talk, an order, the slowest way to the next cell, and calm."""
    stretch = min(config.docking_stretch_m, config.cell_m)
    drive_s = (config.cell_m - stretch) / config.cruise_mps + stretch / config.docking_mps
    return 2 * config.talk_ticks + 1 + ceil((drive_s + config.settle_s) / period_s)
