"""The mission computer's part while boats assemble: it listens, stops them when something is lost, and plans the rest.

A boat that falls silent in a docked group is carried along, and nothing has to change. One that falls silent on its own
is missing in the structure; so is a dock whose magnets fail. Then all boats stop at their next cells, and what they
report is the start of a new plan.

Boats that find their ways by themselves cannot carry a silent one along, for it may be the one that thinks for its
group; and nothing proves that they will not dance around each other forever. So the foreman stops them after any death,
and when nobody has come any farther for long, and the rest is planned here.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from mission_computer.assembly.dock_faults import Side, broken_sides
from mission_computer.assembly.found_ways import FoundWays
from mission_computer.assembly.redispatch import Midway, NothingToAddError, plan_rest
from mission_computer.assembly.timed_plan import TimedLimits
from swarm_msgs_py.assembly.boat_frames import BoatFrame
from swarm_msgs_py.assembly.docking import docked_contacts
from swarm_msgs_py.assembly.faces import Cell, Face, Layout, turned, turned_face
from swarm_msgs_py.assembly.plan import AssemblyPlan, TimedPaths
from swarm_msgs_py.assembly.precedence import crews_of, turning_step
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.assembly.progress_frames import ProgressFrame

STALL_TICKS = 60
"""Boats that find their ways by themselves are helped when nobody has moved for so long: three of their steps."""
REPLANS_MAX = 8
"""After so many losses the foreman is content with what stands."""


class ForemanState(Enum):
    """What the foreman is doing."""

    WATCHING = "watching"
    STOPPING = "stopping"
    DONE = "done"
    GAVE_UP = "gave up"


@dataclass(frozen=True, slots=True)
class ForemanReport:
    """How the assembly stands.

    Attributes
    ----------
    state : ForemanState
    epoch : int
        Number of the plan.
    is_halting : bool
        Boats are to stop.
    built, wanted : int
        Boats in the largest docked group that is known of, and targets of the operator's structure.
    note : str
        What was lost, in one line; empty while nothing was.
    """

    state: ForemanState
    epoch: int
    is_halting: bool
    built: int
    wanted: int
    note: str


class Foreman:
    """Watches one assembly.

    Parameters
    ----------
    problem : AssemblyProblem
    plan : AssemblyPlan
        With timed paths or guideposts.
    seed : int
        Of further plans.
    silence_ticks : int
        A boat that was not heard for so long is taken for dead.
    limits : TimedLimits
        Of further plans.

    Attributes
    ----------
    problem, plan
        What boats are to follow now.
    epoch : int
        Its number, from 1.
    """

    def __init__(
        self, problem: AssemblyProblem, plan: AssemblyPlan, seed: int, silence_ticks: int, limits: TimedLimits
    ) -> None:
        self.problem, self.plan, self.epoch = problem, plan, 1
        self._wanted = problem.targets
        self._seed = seed
        self._limits = limits
        self._silence_ticks = silence_ticks
        self._heard: dict[int, ProgressFrame] = {}  # of the present plan
        self._alive_at: dict[int, int] = {}
        self._found_ways = FoundWays(problem, plan)
        self._state = ForemanState.WATCHING
        self._settled = 0
        self._is_largest = False  # of what the present plan builds
        self._notes: list[str] = []
        self._turned = [0] * problem.boat_count  # quarter turns since the start, before those of the present plan
        self._held: set[Side] = set()
        self._failed: list[tuple[Side, Side]] = []

    def step(self, tick: int, frames: Sequence[ProgressFrame], words: Sequence[BoatFrame] = ()) -> ForemanReport:
        """Listen for one tick, and decide."""
        self._found_ways.hear(tick, words)
        for frame in frames:
            self._alive_at[frame.boat] = tick
            if frame.epoch == self.epoch:
                self._heard[frame.boat] = frame
                self._held |= {self._side(frame.boat, face) for face in frame.contacts}
        if self._state is ForemanState.WATCHING:
            self._watch(tick)
        elif self._state is ForemanState.STOPPING:
            self._settled = self._settled + 1 if self._have_stopped(tick) else 0
            if self._settled > self._silence_ticks // 4:
                self._plan_rest(tick)
        return self._report()

    def _watch(self, tick: int) -> None:
        boats = self.plan.dispatch.boats
        is_timed = self.plan.paths is not None
        docked = {boat for group in self._groups() for boat in group} if is_timed else set()
        lost = [boat for boat in boats if self._is_silent(boat, tick) and boat not in docked]
        stuck = [boat for boat in boats if boat in self._heard and self._heard[boat].is_stuck]
        if lost or stuck:
            self._notes.append(_what(lost, stuck))
            self._state = ForemanState.STOPPING
            self._settled = 0
        elif self._is_complete():
            self._state = ForemanState.DONE
        elif not is_timed and self._found_ways.are_stalled(tick, STALL_TICKS):
            self._notes.append("boats found no way by themselves")
            self._state = ForemanState.STOPPING
            self._settled = 0

    def _is_silent(self, boat: int, tick: int) -> bool:
        return tick - self._alive_at.get(boat, 0) > self._silence_ticks

    def _is_complete(self) -> bool:
        groups = self._groups()
        return self._wanted_now() == 1 or (bool(groups) and len(groups[0]) == self._wanted_now() and self._arrived())

    def _wanted_now(self) -> int:
        return self.problem.target_count

    def _arrived(self) -> bool:
        if self.plan.paths is None:
            return True  # a group that holds together is all there is to reach
        steps = self.plan.paths.steps
        return any(frame.steps_done == steps for frame in self._heard.values())

    def _have_stopped(self, tick: int) -> bool:
        boats = range(self.problem.boat_count)
        return all(
            self._is_silent(boat, tick) or (boat in self._heard and self._heard[boat].is_halted) for boat in boats
        )

    def _groups(self) -> list[tuple[int, ...]]:
        """Return the groups of two or more boats whose foils say that they hold together, the largest first."""
        boats = self.plan.dispatch.boats
        links: dict[int, set[int]] = {}
        for contact in docked_contacts(self.problem.targets, self._layouts_at_targets(), self.problem.gender):
            one, other = boats[contact.one], boats[contact.other]
            if self._tells(one, contact.face) or self._tells(other, contact.face.opposite):
                links.setdefault(one, set()).add(other)
                links.setdefault(other, set()).add(one)
        groups: list[tuple[int, ...]] = []
        seen: set[int] = set()
        for first in sorted(links):
            if first in seen:
                continue
            group, border = {first}, [first]
            while border:
                fresh = links[border.pop()] - group
                group |= fresh
                border.extend(fresh)
            seen |= group
            groups.append(tuple(sorted(group)))
        return sorted(groups, key=lambda group: (-len(group), group))

    def _layouts_at_targets(self) -> tuple[Layout, ...]:
        return self.plan.dispatch.layouts(self.problem)

    def _tells(self, boat: int, face: Face) -> bool:
        heard = self._heard.get(boat)
        return heard is not None and face in heard.contacts

    def _plan_rest(self, tick: int) -> None:
        if self.epoch > REPLANS_MAX:
            self._is_largest = False  # that was said of what the plan would have built
            self._state = ForemanState.GAVE_UP
            return
        try:
            rest = plan_rest(self._midway(tick), self._seed + self.epoch, self._limits)
        except NothingToAddError as error:
            self._notes.append(str(error))
            self._is_largest = error.is_proof
            self._state = ForemanState.GAVE_UP
            return
        self.problem, self.plan, self._is_largest = rest.problem, rest.plan, rest.is_largest
        self.epoch += 1
        self._notes += _what_changed(self._wanted, self.problem.targets)
        self._heard.clear()
        self._state = ForemanState.WATCHING

    def _midway(self, tick: int) -> Midway:
        """Return the assembly as it stopped, from what boats told."""
        problem, dispatch, paths = self.problem, self.plan.dispatch, self.plan.paths
        groups = self._groups()
        dead = {boat for boat in range(problem.boat_count) if self._is_silent(boat, tick)}
        if paths is None:
            starts = self._found_ways.cells
            between = {self._found_ways.next_of(boat) for boat in dead}
        else:
            starts, between = self._by_steps(paths, groups, dead)
        self._failed += self._open_docks(groups)
        broken = broken_sides(self._failed, self._held)
        docked = {boat for group in groups for boat in group}
        stopped = replace(
            problem,
            starts=tuple(starts),
            layouts=self._working_layouts(broken),
            obstacles=tuple(sorted({*problem.obstacles, *(between - set(starts))})),
            is_midway=True,
        )
        return Midway(
            stopped, dispatch, tuple(groups), frozenset(dead), frozenset(boat for boat, _ in broken) - frozenset(docked)
        )

    def _by_steps(
        self, paths: TimedPaths, groups: Sequence[tuple[int, ...]], dead: set[int]
    ) -> tuple[list[Cell], set[Cell]]:
        """Return where boats stopped that follow paths, and the cells that dead ones may be halfway to."""
        problem, dispatch, cells = self.problem, self.plan.dispatch, paths.cells
        steps = {boat: self._heard[boat].steps_done if boat in self._heard else 0 for boat in dispatch.boats}
        for group in groups:  # who is carried is where its group is
            reached = max(steps[boat] for boat in group if boat not in dead) if set(group) - dead else 0
            steps |= dict.fromkeys(group, reached)
        starts = list(problem.starts)
        for boat, step in steps.items():
            starts[boat] = _cell(cells[step, boat])
        docked = {boat for group in groups for boat in group}
        # A boat that died on its way is somewhere between the cell that it told and the next.
        between = {_cell(cells[min(steps[boat] + 1, len(cells) - 1), boat]) for boat in dead - docked if boat in steps}
        return starts, between

    def _working_layouts(self, broken: Collection[Side]) -> tuple[Layout, ...]:
        """Return how boats are turned now, without the mechanisms that are broken, and remember the turns."""
        layouts = list(self.problem.layouts)
        for boat, turns in zip(self.plan.dispatch.boats, self.plan.dispatch.turns, strict=True):
            if self._has_turned(boat):
                layouts[boat] = turned(layouts[boat], turns)
                self._turned[boat] += turns
        for boat, face in broken:
            working = list(layouts[boat])
            working[turned_face(face, self._turned[boat])] = 0
            layouts[boat] = (working[Face.UP], working[Face.DOWN], working[Face.LEFT], working[Face.RIGHT])
        return tuple(layouts)

    def _has_turned(self, boat: int) -> bool:
        paths = self.plan.paths
        if paths is None:
            return True  # they turn where they start
        crews = crews_of(self.problem, self.plan.dispatch, self.plan.tree, paths, boat)
        done = self._heard[boat].steps_done if boat in self._heard else 0
        return done >= turning_step(self.problem, crews, paths.cells, boat)

    def _side(self, boat: int, face: Face) -> Side:
        """Return a side of a boat that looks to a side of the grid when the boat is turned for its target."""
        dispatch = self.plan.dispatch
        turns = dispatch.turns[dispatch.boats.index(boat)] if boat in dispatch.boats else 0
        return boat, turned_face(face, -(self._turned[boat] + turns))

    def _open_docks(self, groups: Sequence[tuple[int, ...]]) -> list[tuple[Side, Side]]:
        """Return the pairs of sides that met and do not hold."""
        dispatch = self.plan.dispatch
        group_of = {boat: number for number, group in enumerate(groups) for boat in group}
        found = []
        for contact in docked_contacts(self.problem.targets, self._layouts_at_targets(), self.problem.gender):
            one, other = dispatch.boats[contact.one], dispatch.boats[contact.other]
            is_closed = self._tells(one, contact.face) or self._tells(other, contact.face.opposite)
            have_met = group_of.get(one, -1 - one) == group_of.get(other, -1 - other)
            is_stuck = any(boat in self._heard and self._heard[boat].is_stuck for boat in (one, other))
            if not is_closed and (have_met or (is_stuck and self._are_neighbors(one, other, contact.face))):
                found.append((self._side(one, contact.face), self._side(other, contact.face.opposite)))
        return found

    def _are_neighbors(self, one: int, other: int, face: Face) -> bool:
        if one not in self._heard or other not in self._heard:
            return False
        if self.plan.paths is None:
            (x, y), (u, v) = (self._found_ways.cells[boat] for boat in (one, other))
        else:
            cells = self.plan.paths.cells
            (x, y), (u, v) = (_cell(cells[self._heard[boat].steps_done, boat]) for boat in (one, other))
        return (u - x, v - y) == face.offset

    def _report(self) -> ForemanReport:
        groups = self._groups()
        built, wanted = len(groups[0]) if groups else 1, len(self._wanted)
        notes = list(self._notes)
        if self._state in (ForemanState.DONE, ForemanState.GAVE_UP) and built < wanted:
            is_proven = self._is_largest and (self._state is ForemanState.GAVE_UP or built == self._wanted_now())
            proof = " (proven: no larger one can be put together)" if is_proven else " (best found)"
            notes.append(f"finished the largest connected sub-structure: {built} of {wanted}{proof}")
        is_halting = self._state is ForemanState.STOPPING
        return ForemanReport(self._state, self.epoch, is_halting, built, wanted, "; ".join(notes))


def _what(lost: Sequence[int], stuck: Sequence[int]) -> str:
    parts = []
    if lost:
        parts.append(f"boat {', '.join(map(str, lost))} fell silent on its way")
    if stuck:
        parts.append(f"the docks of boat {', '.join(map(str, stuck))} do not hold")
    return ", ".join(parts)


def _what_changed(wanted: Sequence[Cell], kept: Sequence[Cell]) -> list[str]:
    """Return what the operator must know of a new plan: places that are given up, and where the rest is built."""
    notes = []
    if len(kept) < len(wanted):
        notes.append(f"{len(wanted) - len(kept)} of {len(wanted)} places are given up")
    if not set(kept) <= set(wanted):
        x, y = kept[0]
        shifts = {(x - u, y - v) for u, v in wanted}
        dx, dy = next(d for d in sorted(shifts) if {(x - d[0], y - d[1]) for x, y in kept} <= set(wanted))
        notes.append(f"the structure is built {dx} cells to the right and {dy} up, beside what lies in its place")
    return notes


def _cell(row: np.ndarray[tuple[int, ...], np.dtype[np.int64]]) -> tuple[int, int]:
    return int(row[0]), int(row[1])
