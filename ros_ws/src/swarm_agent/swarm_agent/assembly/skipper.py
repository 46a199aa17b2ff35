"""A boat in continuous space: follows its timed guideposts, in step with its docked group, and docks by contact.

Each step leads from the center of a cell to the next. A boat on its own leaves when those are gone that the plan lets
pass before it. A docked group leaves together, at a tick that its leader announces once all members have arrived and
their contact foils say that the group holds. Who hears that late catches up: the moment of departure is told, not the
order to go.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_agent.assembly.crew_contacts import CrewContacts
from swarm_agent.assembly.timed_following import TimedFollower
from swarm_msgs_py.assembly.faces import Face, turned_face
from swarm_msgs_py.assembly.orders import TimedOrders
from swarm_msgs_py.assembly.precedence import Crew, crews_of
from swarm_msgs_py.assembly.progress_frames import NO_DEPARTURE, ProgressFrame
from swarm_msgs_py.config import Config, setting
from swarm_msgs_py.types import FloatArray

QUARTER_RAD = 0.5 * np.pi
"""A quarter turn [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SkipperConfig(Config):
    """How boats follow guideposts in continuous space."""

    cell_m: float = setting(0.25, "edge of a grid cell (paper)", unit="m", above=0.0)
    cruise_mps: float = setting(0.15, "speed from cell to cell", unit="m/s", above=0.0, maximum=1.0)
    docking_mps: float = setting(0.05, "speed on the last stretch to a partner", unit="m/s", above=0.0, maximum=1.0)
    docking_stretch_m: float = setting(0.10, "how long that stretch is", unit="m", minimum=0.0)
    turn_radps: float = setting(0.5, "rate of turning to the orientation of the dispatch", unit="rad/s", above=0.0)
    arrival_m: float = setting(0.04, "a boat nearer to a cell's center has arrived", unit="m", above=0.0)
    arrival_deg: float = setting(6.0, "and turned by no more than this", unit="deg", above=0.0)
    notice_ticks: int = setting(
        2, "ticks between a group's announcement and its departure, so that members hear it twice", minimum=1
    )
    docking_patience_s: float = setting(
        15.0, "groups that met and do not hold together for so long are stuck", unit="s", minimum=1.0, maximum=600.0
    )
    silence_s: float = setting(
        5.0, "a boat that was not heard for so long is taken for dead", unit="s", minimum=1.0, maximum=600.0
    )


@dataclass(frozen=True, slots=True, eq=False)
class SkipperInputs:
    """What a boat learns in one tick.

    Attributes
    ----------
    tick : int
    pose : (3,) array
        Measured x, y [m] and heading [rad], world frame.
    reference : (3,) array
        The pose that its firmware holds now.
    contacts : frozenset of Face
        Sides whose foils are pressed, in the boat's own frame.
    frames : sequence of ProgressFrame
        Heard since the last tick.
    """

    tick: int
    pose: FloatArray
    reference: FloatArray
    contacts: frozenset[Face]
    frames: Sequence[ProgressFrame]


@dataclass(frozen=True, slots=True, eq=False)
class SkipperOutputs:
    """What a boat does and says.

    Attributes
    ----------
    velocity : (3,) array
        Of the reference, world frame [m/s], [rad/s].
    frame : ProgressFrame
    is_done : bool
        It is at its target, and its group holds together.
    """

    velocity: FloatArray
    frame: ProgressFrame
    is_done: bool


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
        self._heading = QUARTER_RAD * (round(heading / QUARTER_RAD) - turns)
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
        velocity = self._velocity(inputs)
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
        return SkipperOutputs(velocity, frame, self._follower.is_done and holds)

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
        return np.append(self._cells[step], self._heading)

    def _has_arrived(self, inputs: SkipperInputs) -> bool:
        target = self._target(inputs.tick)
        gap = target - inputs.reference
        gap[2] = _wrapped(gap[2])
        off = target - inputs.pose
        is_near = np.hypot(off[0], off[1]) < self._config.arrival_m
        is_turned = abs(_wrapped(off[2])) < np.radians(self._config.arrival_deg)
        return bool(np.abs(gap).max() < 1e-6 and is_near and is_turned)

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

    def _velocity(self, inputs: SkipperInputs) -> FloatArray:
        """Return how the reference is to move in this tick: straight to its cell, slowly where partners meet."""
        config, period = self._config, self._period_s
        gap = self._target(inputs.tick) - inputs.reference
        distance = float(np.hypot(gap[0], gap[1]))
        reach = config.cruise_mps * period
        if self._follower.is_docking and self._is_moving(inputs.tick):
            slow = config.docking_mps * period
            reach = min(reach, max(slow, distance - config.docking_stretch_m))
        planar = gap[:2] * min(1.0, reach / distance) if distance > 0.0 else np.zeros(2)
        turn = _wrapped(gap[2])
        turn = float(np.clip(turn, -config.turn_radps * period, config.turn_radps * period))
        return np.array([planar[0], planar[1], turn]) / period


def grid_faces(contacts: frozenset[Face], heading: float) -> frozenset[Face]:
    """Return the sides of its cell to which a boat's own sides look, given its heading [rad]."""
    clockwise = -round(heading / QUARTER_RAD)
    return frozenset(turned_face(face, clockwise) for face in contacts)


def _wrapped(angle: float) -> float:
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)
