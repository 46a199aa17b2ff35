"""Engine that runs all actors in this process, in lockstep, without ROS."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from threading import Event
from typing import Any

from bringup.engine import Actors, AgentActor, MissionActor, TickRecord
from bringup.filming import FilmOrder, develop, filming
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.electronics import arrival_line, death_line
from swarm_sim.ticked_world import TickedWorld


class InProcessEngine:
    """Runs one scenario in this process; implements `bringup.engine.Engine`.

    Parameters
    ----------
    actors : Actors
    real_time : bool
        Start ticks no faster than the wall clock.
    film : FilmOrder or None
        That what the mission computer sees is to be filmed.
    """

    def __init__(self, actors: Actors, *, real_time: bool = False, film: FilmOrder | None = None) -> None:
        self._actors = actors
        self._open = ExitStack()
        self._film_order, self._film = film, self._open.enter_context(filming(film))
        self._real_time = real_time
        self._simulation: TickedWorld | None = None
        self._mission: MissionActor | None = None
        self._agents: dict[NodeId, AgentActor] = {}
        self._dead: frozenset[NodeId] = frozenset()  # who has died as the scenario says
        self.startup_s = 0.0
        self.notes: tuple[str, ...] = ()

    def __enter__(self) -> InProcessEngine:
        """Make all actors."""
        began = time.monotonic()
        self._simulation = self._actors.simulation()
        self._mission = self._actors.mission()
        self._agents = {robot: self._actors.agent(robot) for robot in sorted(self._actors.robots)}
        self.startup_s = time.monotonic() - began
        return self

    def __exit__(self, *error: object) -> None:
        """Close the world, and the film."""
        self._open.close()
        self.notes = develop(self._film_order)
        if self._simulation is not None:
            self._simulation.close()
            self._simulation = None

    def ticks(self) -> Iterator[TickRecord[Any, Any]]:
        """Yield one record per tick.

        Raises
        ------
        RuntimeError
            If the engine was not entered.
        """
        if self._simulation is None or self._mission is None:
            raise RuntimeError("the engine is not running; use it as a context manager")
        began = time.monotonic()
        pause = Event()  # never set: a wait that a signal handler's exception can end
        while True:
            if self._real_time:
                ahead = self._simulation.tick * self._actors.period_s - (time.monotonic() - began)
                pause.wait(max(0.0, ahead))
            yield self._tick(self._simulation, self._mission)

    def _tick(self, simulation: TickedWorld, mission: MissionActor) -> TickRecord[Any, Any]:
        """Let everybody answer one tick, then let the world move on."""
        seen = simulation.observe()
        died, arrived = simulation.take_died(), simulation.take_arrived()
        self._dead = (self._dead | frozenset(died)) - frozenset(arrived)
        orders = None if MISSION in self._dead else mission.step(seen.mission)
        if orders is not None:
            self._film.take(mission, orders)
        outputs = {robot: self._agents[robot].step(inputs) for robot, inputs in sorted(seen.agents.items())}
        simulation.apply(
            {robot: output.command for robot, output in outputs.items()},
            {robot: output.outbox for robot, output in outputs.items()} | ({MISSION: orders.outbox} if orders else {}),
        )
        notice = orders.report.notice if orders is not None else ""
        return TickRecord(
            tick=seen.tick,
            truth=simulation.advance(),
            reports={robot: output.report for robot, output in outputs.items()},
            mission=orders.report if orders is not None else None,
            plan=orders.plan if orders is not None else None,
            alerts=(*map(death_line, died), *map(arrival_line, arrived), *([notice] if notice else [])),
            lost=frozenset(self._actors.robots) - frozenset(seen.agents) | self._dead,
        )
