"""A boat in continuous space: follows its timed guideposts, in step with its docked group, and docks by contact.

Each step leads from the center of a cell to the next. A boat on its own leaves when those are gone that the plan lets
pass before it. A docked group leaves together, at a tick that its leader announces once all members have arrived and
their contact foils say that the group holds. Who hears that late catches up: the moment of departure is told, not the
order to go.
"""

from __future__ import annotations

import numpy as np

from swarm_agent.assembly.crew_contacts import CrewContacts
from swarm_agent.assembly.steering import (
    SkipperConfig,
    SkipperInputs,
    SkipperOutputs,
    grid_faces,
    has_arrived,
    start_heading,
    steered,
)
from swarm_agent.assembly.timed_following import TimedFollower
from swarm_msgs_py.assembly.faces import Face
from swarm_msgs_py.assembly.orders import TimedOrders
from swarm_msgs_py.assembly.precedence import Crew, crews_of
from swarm_msgs_py.assembly.progress_frames import NO_DEPARTURE, ProgressFrame
from swarm_msgs_py.types import FloatArray


class Skipper:
    """One boat with a target.

    Parameters
    ----------
    boat : int
    orders : TimedOrders
    config : SkipperConfig
    period_s : float
        Control period [s].
    heading : float
        Of the boat when it gets the orders [rad].
    """

    def __init__(self, boat: int, orders: TimedOrders, config: SkipperConfig, period_s: float, heading: float) -> None:
        self._boat = boat
        self._orders = orders
        self._epoch = orders.epoch
        self._config = config
        self._period_s = period_s
        self._follower = TimedFollower(orders.problem, orders.dispatch, orders.tree, orders.paths, boat)
        self._holds = CrewContacts(orders.problem, orders.dispatch)
        self._cells = config.cell_m * orders.paths.cells[:, boat]
        turns = orders.dispatch.turns[orders.dispatch.boats.index(boat)]
        self._headings = start_heading(heading, 0), start_heading(heading, turns)
        self._met_tick: int | None = None
        self.is_halting = False
        self._heard: dict[int, ProgressFrame] = {}  # of the same plan
        self._alive_at: dict[int, int] = {}
        self._began: int | None = None
        self._departure = NO_DEPARTURE
        self._crews: dict[int, list[Crew]] = {}
        self._silence_ticks = round(config.silence_s / period_s)

    @property
    def steps(self) -> int:
        """Steps of the plan."""
        return self._orders.paths.steps

    def step(self, inputs: SkipperInputs) -> SkipperOutputs:
        """Act in one tick."""
        if self._began is None:
            self._began = inputs.tick
        for frame in inputs.frames:
            self._alive_at[frame.boat] = inputs.tick
            if frame.epoch == self._epoch:
                self._heard[frame.boat] = frame
        if self._is_moving(inputs.tick) and self._has_arrived(inputs):
            self._follower.go()
            self._departure = NO_DEPARTURE
        if not self._is_moving(inputs.tick):
            self._consider_departure(inputs)
        target = self._target(inputs.tick)
        is_docking = self._follower.is_docking and self._is_moving(inputs.tick)
        velocity = steered(self._config, target, inputs.reference, self._period_s, is_docking=is_docking)
        holds = self._crew_holds(inputs)
        frame = ProgressFrame(
            self._boat,
            self._epoch,
            self._follower.steps_done,
            self._departure,
            grid_faces(inputs.contacts, inputs.pose[2]),
            self.is_halting and self._departure == NO_DEPARTURE and self._has_arrived(inputs),
            self._is_stuck(inputs, holds),
        )
        return SkipperOutputs(velocity, frame, self._follower.is_done and holds, target[:2])

    def _is_stuck(self, inputs: SkipperInputs, holds: bool) -> bool:
        """Return whether the group stands where it met its partner for too long, and does not hold together."""
        if holds or not self._has_arrived(inputs):
            self._met_tick = None
            return False
        if self._met_tick is None:
            self._met_tick = inputs.tick
        return (inputs.tick - self._met_tick) * self._period_s > self._config.docking_patience_s

    def _is_moving(self, tick: int) -> bool:
        return tick >= self._departure

    def _target(self, tick: int) -> FloatArray:
        step = self._follower.steps_done + self._is_moving(tick)
        return np.append(self._cells[step], self._headings[step >= self._follower.turning_step])

    def _has_arrived(self, inputs: SkipperInputs) -> bool:
        return has_arrived(self._config, self._target(inputs.tick), inputs)

    def _consider_departure(self, inputs: SkipperInputs) -> None:
        """Find out, or decide, when the group leaves."""
        follower, tick = self._follower, inputs.tick
        if follower.is_done:
            return
        crew = [boat for boat in follower.crew if boat == self._boat or not self._is_silent(boat, tick)]
        if crew[0] == self._boat:
            if self._departure == NO_DEPARTURE and not self.is_halting and self._may_leave(inputs):
                # Nobody has to hear of the departure of a boat that is alone.
                self._departure = tick if len(follower.crew) == 1 else tick + self._config.notice_ticks
            return
        leader = self._heard.get(crew[0])
        if leader is None:
            return
        steps, departure = leader.steps_done, leader.departure_tick
        if steps > follower.steps_done:
            self._departure = tick
        elif steps == follower.steps_done:
            self._departure = departure

    def _may_leave(self, inputs: SkipperInputs) -> bool:
        if not self._has_arrived(inputs) or not self._crew_holds(inputs):
            return False
        reached = {boat: frame.steps_done for boat, frame in self._heard.items()}
        for boat in self._orders.dispatch.boats:
            if boat != self._boat and self._is_silent(boat, inputs.tick):
                reached[boat] = max(reached.get(boat, 0), self._carried_to(boat, inputs.tick))
        return self._follower.may_go(reached)

    def _carried_to(self, silent: int, tick: int) -> int:
        """Return the last step to which a docked group has carried a boat that is silent."""
        if silent not in self._crews:
            orders = self._orders
            self._crews[silent] = crews_of(orders.problem, orders.dispatch, orders.tree, orders.paths, silent)
        crews = self._crews[silent]
        own = {self._boat: self._follower.steps_done}
        told = own | {b: f.steps_done for b, f in self._heard.items() if not self._is_silent(b, tick)}
        return max(
            (step for step, crew in enumerate(crews) if any(told.get(boat, -1) >= step for boat in crew)), default=0
        )

    def _crew_holds(self, inputs: SkipperInputs) -> bool:
        """Return whether the foils say that the whole group holds together."""
        told: dict[int, frozenset[Face]] = {boat: frame.contacts for boat, frame in self._heard.items()}
        own = {self._boat: grid_faces(inputs.contacts, inputs.pose[2])}
        return self._holds.is_connected(self._follower.crew, told | own)

    def _is_silent(self, boat: int, tick: int) -> bool:
        return tick - self._alive_at.get(boat, self._began or 0) > self._silence_ticks
