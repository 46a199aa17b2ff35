"""One boat of an assembly that finds its way by itself: no clock, no thread, no I/O."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from swarm_agent.assembly.crew import Orders
from swarm_agent.assembly.pilot import Pilot, PilotConfig, Sight
from swarm_msgs_py.assembly.boat_frames import BoatFrame, Move, Phase
from swarm_msgs_py.assembly.faces import Cell


@dataclass(frozen=True, slots=True)
class BoatInputs:
    """What a boat gets in one phase of a step.

    Attributes
    ----------
    step : int
        Number of the step.
    phase : Phase
    cell : Cell
        Where the boat is.
    seen : tuple of Cell
        Occupied cells within its perception radius, its own not among them.
    frames : sequence of BoatFrame
        Heard since the last phase.
    """

    step: int
    phase: Phase
    cell: Cell
    seen: tuple[Cell, ...]
    frames: Sequence[BoatFrame]


@dataclass(frozen=True, slots=True)
class BoatOutputs:
    """What a boat says and does.

    Attributes
    ----------
    frame : BoatFrame or None
        To be broadcast.
    move : Move
        What its group is to do; of a docked group, the leader's word counts.
    node : int
        Node of the tree that it takes itself to be part of.
    """

    frame: BoatFrame | None
    move: Move
    node: int


class Boat:
    """A boat with a target.

    Parameters
    ----------
    boat : int
        Its number.
    orders : Orders
    config : PilotConfig
    """

    def __init__(self, boat: int, orders: Orders, config: PilotConfig) -> None:
        self._boat = boat
        self._orders = orders
        self._target = orders.dispatch.boats.index(boat)
        self._node = orders.tree.leaf_of()[self._target]
        self._pilot = Pilot(orders, config)
        self._looks: dict[int, BoatFrame] = {}
        self._claim: BoatFrame | None = None

    def step(self, inputs: BoatInputs) -> BoatOutputs:
        """Take part in one phase of a step."""
        x, y = self._orders.problem.targets[self._target]
        shift = (inputs.cell[0] - x, inputs.cell[1] - y)
        frame: BoatFrame | None = None
        move = Move.STAY
        if inputs.phase is Phase.LOOK:
            frame = BoatFrame(Phase.LOOK, self._boat, inputs.step, self._node, shift, seen=inputs.seen)
            if self._claim is not None and self._claim.node == self._node:  # what its group was about last
                last = self._claim
                frame = replace(frame, move=last.move, is_docking=last.is_docking, urgency=last.urgency)
        elif inputs.phase is Phase.CLAIM:
            self._looks = {f.boat: f for f in inputs.frames if f.phase is Phase.LOOK and f.step == inputs.step & 0xFFFF}
            self._merge(shift)
            if self._orders.leader(self._node) == self._boat:
                sight = self._sight(inputs.seen, shift, self._looks)
                frame = self._claim = self._pilot.claim(self._boat, inputs.step, self._node, shift, sight)
        elif self._claim is not None and self._orders.leader(self._node) == self._boat:
            claims = {f.boat: f for f in inputs.frames if f.phase is Phase.CLAIM and f.step == inputs.step & 0xFFFF}
            crew = set(self._orders.crew(self._node)) - {self._boat}
            # With a look missing the leader does not know what is around that boat: better stay.
            if self._looks.keys() >= crew:
                move = self._pilot.decide(self._claim, self._sight(inputs.seen, shift, claims))
        return BoatOutputs(frame, move, self._node)

    def _merge(self, shift: Cell) -> None:
        """Become part of a larger group when the partner stands docked, or when one of the larger group says so."""
        orders = self._orders
        changed = True
        while changed:
            changed = False
            partner, parent = orders.tree.sibling(self._node), orders.tree.nodes[self._node].parent
            for words in self._looks.values():
                is_known = words.node < len(orders.tree.nodes)
                if parent < 0 or not is_known or words.shift != shift:
                    continue
                stands = words.node == partner and shift == orders.guideposts.shifts[parent]
                if stands or (words.node < self._node and orders.contains(words.node, self._node)):
                    self._node = parent if stands else words.node
                    changed = True
                    break

    def _sight(self, seen: tuple[Cell, ...], shift: Cell, frames: dict[int, BoatFrame]) -> Sight:
        """Return the other groups that spoke, and the cells in sight of its own group of which nobody did."""
        orders = self._orders
        crew = set(orders.crew(self._node))
        words = [one for one in frames.values() if one.boat not in crew and one.node < len(orders.tree.nodes)]
        others = {orders.leader(one.node): one for one in merged_words(orders, words)}
        told = set(orders.cells(self._node, shift))
        for one in others.values():
            told.update(orders.cells(one.node, one.shift))
        told.update(orders.problem.starts[boat] for boat in orders.dispatch.idle(orders.problem))
        sighted = set(seen)
        for boat in crew & self._looks.keys():
            sighted.update(self._looks[boat].seen)
        return Sight(others, tuple(sorted(sighted - told)))


def merged_words(orders: Orders, words: Iterable[BoatFrame]) -> list[BoatFrame]:
    """Return one word per group, where several boats spoke, and partners that stand docked but do not know it yet.

    Parameters
    ----------
    orders : Orders
    words : iterable of BoatFrame
        Of one phase, with nodes of the tree.
    """
    by_node = {one.node: one for one in sorted(words, key=lambda one: -one.boat)}
    for node in range(len(orders.tree.nodes) - 1, 0, -1):  # children before their parents
        partner, parent = orders.tree.sibling(node), orders.tree.nodes[node].parent
        if node in by_node and partner in by_node:
            one, other = by_node[node], by_node[partner]
            if one.shift == other.shift == orders.guideposts.shifts[parent]:
                by_node.setdefault(parent, replace(one, node=parent, boat=orders.leader(parent)))
    whole = [node for node in sorted(by_node) if not any(n < node and orders.contains(n, node) for n in by_node)]
    return [by_node[node] for node in whole]
