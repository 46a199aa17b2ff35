"""How a group's leader picks its moves: goal, path, and who gives way (algorithm 4, rules 1 and 2 of the paper).

The rules keep every pair of groups clear of each other whatever frames are lost:

* nobody moves too near to where another group is perceived to be now, except to its docking partner;
* of two groups whose claims are too near to each other, the one of lower rank stays;
* a group that is perceived but was not heard may go anywhere, so nobody moves to where it could meet that.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from swarm_agent.assembly.crew import Orders
from swarm_agent.assembly.group_path import group_path, moved, too_near
from swarm_msgs_py.assembly.boat_frames import URGENCY_MAX, BoatFrame, Move, Phase
from swarm_msgs_py.assembly.faces import Cell
from swarm_msgs_py.assembly.problem import chebyshev
from swarm_msgs_py.config import Config, setting

Rank = tuple[bool, int, int, int]

ASIDE_CELLS = 4
"""How far ahead of a group of higher rank the way is cleared, and how far one goes for that."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotConfig(Config):
    """Tuning of navigation on the grid."""

    perception_radius_cells: int = setting(3, "how far a boat sees other boats (simulator of the paper)", minimum=2)
    patience_steps: int = setting(1, "wait this long for a group of lower rank before going around it", minimum=0)
    urgency_steps: int = setting(6, "a group that is held up for so many steps gets a higher rank", minimum=1)


@dataclass(frozen=True, slots=True)
class Sight:
    """What a leader knows of its surroundings in one step.

    Attributes
    ----------
    others : dict
        Last word of each other group that was heard in this step, by its leader.
    unheard : tuple of Cell
        Occupied cells of which nobody spoke.
    """

    others: dict[int, BoatFrame]
    unheard: tuple[Cell, ...]


class Pilot:
    """Thinks for the group that its boat leads.

    Parameters
    ----------
    orders : Orders
    config : PilotConfig
    """

    def __init__(self, orders: Orders, config: PilotConfig) -> None:
        self._orders = orders
        self._config = config
        self._held_up = 0
        self._pause = 0
        self._place: tuple[int, Cell] = (-1, (0, 0))
        self._visits: dict[Cell, int] = {}
        self._idle = too_near(orders.problem.starts[boat] for boat in orders.dispatch.idle(orders.problem))

    def claim(self, boat: int, step: int, node: int, shift: Cell, sight: Sight) -> BoatFrame:
        """Return what the group wants to do in this step."""
        is_docking, goals = self._goals(node, shift, sight)
        self._notice_loop(boat, node, shift)
        move = Move.STAY
        if shift not in goals:
            if is_docking:
                move = _move_between(shift, goals[0])
            else:
                path = self._plan(node, shift, goals, sight)
                move = _move_between(shift, path[0]) if path else Move.STAY
                self._held_up += not path and self._pause == 0
        else:
            self._held_up = 0
        urgency = min(self._held_up // self._config.urgency_steps, URGENCY_MAX)
        return BoatFrame(Phase.CLAIM, boat, step, node, shift, move, is_docking, urgency)

    def decide(self, claim: BoatFrame, sight: Sight) -> Move:
        """Return what the group does, given what it claimed and what the others did."""
        if claim.move is Move.STAY or not self._is_free(claim, sight):
            self._held_up += claim.move is not Move.STAY
            return Move.STAY
        self._held_up = max(0, self._held_up - 1)
        return claim.move

    def _notice_loop(self, boat: int, node: int, shift: Cell) -> None:
        """Pause when the group comes back to a place: two groups that dance around each other do not end that.

        Pauses differ from boat to boat and from time to time, so that one of the two finds the other standing.
        """
        if node != self._place[0]:
            self._visits.clear()
        if (node, shift) != self._place:
            self._place = node, shift
            count = self._visits[shift] = self._visits.get(shift, 0) + 1
            if count > 1:
                self._held_up += self._config.urgency_steps // 2
                self._pause = 1 + (boat + count) % (self._config.patience_steps + count)

    def _goals(self, node: int, shift: Cell, sight: Sight) -> tuple[bool, list[Cell]]:
        """Return whether the group is on its straight way in, and the shifts that it wants to reach."""
        orders = self._orders
        post = orders.guideposts.shifts[node]
        if not orders.is_visitor(node):
            return False, [post]
        partner = orders.tree.sibling(node)
        words = sight.others.get(orders.leader(partner))
        approach = orders.approach(node)
        if words is None or words.node != partner or words.shift != orders.guideposts.shifts[partner]:
            closed = self._room_to_join(partner, sight)
            if closed is None or shift not in approach:
                return False, [post]
            # The partner is about to be whole: wait for it as near as it can be met.
            near = [at for at in approach[:-1] if closed.isdisjoint(orders.cells(node, at))]
            return False, near[-1:] or [post]
        if shift in approach[:-1]:
            return True, [approach[approach.index(shift) + 1]]
        closed = too_near(orders.cells(partner, words.shift))
        entries = [at for at in approach[:-1] if not closed.intersection(orders.cells(node, at))]
        return False, entries or [post]

    def _room_to_join(self, node: int, sight: Sight) -> set[Cell] | None:
        """Return the cells that a node needs whose two parts are about to join, None if they are not."""
        orders = self._orders
        children = orders.tree.nodes[node].children
        needed = orders.cells(node, orders.guideposts.shifts[node])
        for child in children:
            words = sight.others.get(orders.leader(child))
            if words is None or words.node != child:
                return None
            if orders.is_visitor(child):
                approach = orders.approach(child)
                if words.shift not in approach:
                    return None
                for at in approach[approach.index(words.shift) :]:
                    needed += orders.cells(child, at)
            elif words.shift != orders.guideposts.shifts[child]:
                return None
        return too_near(needed) if children else None

    def _plan(self, node: int, shift: Cell, goals: list[Cell], sight: Sight) -> list[Cell] | None:
        """Return a way around what stands, what ranks higher, and what has been in the way for too long.

        Where that leaves no way, groups that are not at their guideposts do not count: they will leave, and two of them
        that stand on each other's goals would wait forever.
        """
        orders = self._orders
        mine = self._rank_now(node)
        here = orders.cells(node, shift)
        settled: list[Cell] = list(sight.unheard)
        passing: list[Cell] = []
        for words in sight.others.values():
            cells = orders.cells(words.node, words.shift)
            stands = words.move is Move.STAY
            if not stands and _distance(cells, here) > self._config.perception_radius_cells:
                continue  # it will be somewhere else
            yields = not stands and self._rank_of(words) < mine
            if words.shift == orders.guideposts.shifts[words.node]:
                settled += cells
            elif not yields or self._held_up > self._config.patience_steps:
                passing += cells
        everything = [*settled, *passing]
        if self._pause > 0:
            self._pause -= 1
            aside = self._aside(node, shift, sight)
            return self._path(node, shift, aside, everything) if aside else None
        path = self._path(node, shift, goals, everything)
        if path is None and passing:
            aside = self._aside(node, shift, sight)
            path = self._path(node, shift, aside, everything) if aside else None
        if path is None and passing:
            path = self._path(node, shift, goals, settled)
        return path

    def _path(self, node: int, shift: Cell, goals: list[Cell], obstacles: list[Cell]) -> list[Cell] | None:
        orders = self._orders
        grid = (orders.problem.origin, orders.problem.size)
        return group_path(orders.places(node), shift, goals, grid, too_near(obstacles) | self._idle)

    def _aside(self, node: int, shift: Cell, sight: Sight) -> list[Cell]:
        """Return the shifts at which the group is out of the way of those of higher rank that want to come here."""
        orders = self._orders
        here = orders.cells(node, shift)
        mine = self._rank_now(node)
        swept: set[Cell] = set()
        for words in sight.others.values():
            dx, dy = words.move.offset
            cells = orders.cells(words.node, words.shift)
            ahead = [cell for far in range(ASIDE_CELLS) for cell in moved(cells, (far * dx, far * dy))]
            taken = too_near(ahead)
            if words.move is not Move.STAY and self._rank_of(words) > mine and not taken.isdisjoint(here):
                swept |= taken
        if not swept:
            return []
        reach = range(-ASIDE_CELLS, ASIDE_CELLS + 1)
        around = [(shift[0] + dx, shift[1] + dy) for dx in reach for dy in reach]
        return [at for at in around if swept.isdisjoint(orders.cells(node, at))]

    def _is_free(self, claim: BoatFrame, sight: Sight) -> bool:
        """Return whether the group may do what it claimed."""
        if claim.is_docking and not self._partner_stays(claim, sight):
            return False
        near = {words.boat: too_near(self._orders.cells(words.node, words.shift)) for words in sight.others.values()}
        here = self._orders.cells(claim.node, claim.shift)
        wanted = moved(here, claim.move.offset)
        if not self._is_clear(claim, wanted, near) or not self._idle.isdisjoint(wanted):
            return False
        reachable = {cell for move in Move for cell in moved(sight.unheard, move.offset)}
        if not too_near(reachable).isdisjoint(wanted):
            return False
        mine = self._rank_of(claim)
        near[claim.boat] = too_near(here)
        for words in sight.others.values():
            after = moved(self._orders.cells(words.node, words.shift), words.move.offset)
            # A claim that comes too near to what stands is void: its owner stays, whatever its rank.
            goes_first = self._rank_of(words) > mine and self._is_clear(words, after, near)
            if goes_first and not too_near(after).isdisjoint(wanted):
                return False
        return True

    def _partner_stays(self, claim: BoatFrame, sight: Sight) -> bool:
        partner = self._orders.tree.sibling(claim.node)
        return all(words.move is Move.STAY for words in sight.others.values() if words.node == partner)

    def _is_clear(self, claim: BoatFrame, wanted: list[Cell], near: dict[int, set[Cell]]) -> bool:
        """Return whether cells keep clear of where all other groups are, partners of a docking excepted."""
        partner = self._orders.leader(self._orders.tree.sibling(claim.node)) if claim.is_docking else -1
        return all(boat in (claim.boat, partner) or taken.isdisjoint(wanted) for boat, taken in near.items())

    def _rank_of(self, words: BoatFrame) -> Rank:
        return self._rank(words.node, words.urgency, words.is_docking)

    def _rank_now(self, node: int) -> Rank:
        return self._rank(node, urgency=self._held_up // self._config.urgency_steps, is_docking=False)

    def _rank(self, node: int, urgency: int, is_docking: bool) -> Rank:
        """Return a group's rank: docking first, then the longest held up, then the larger, then the lower leader."""
        crew = self._orders.crew(node)
        return is_docking, urgency, len(crew), -crew[0]


def _move_between(one: Cell, other: Cell) -> Move:
    step = (other[0] - one[0], other[1] - one[1])
    return next(move for move in Move if move.offset == step)


def _distance(cells: Iterable[Cell], others: Iterable[Cell]) -> int:
    return min(chebyshev(one, other) for one in cells for other in others)
