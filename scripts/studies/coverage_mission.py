"""One mission of the coverage family in one process, tick by tick, for studies and tests that interfere on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bringup.coverage.starts import LEADER, START_EDGE, start_positions
from swarm_agent.coverage.agent import CoverageAgent
from swarm_agent.coverage.config import CoverageConfig
from swarm_msgs_py.coverage_io import CoverageMode
from swarm_msgs_py.coverage_orders import AT_REST, CoverageOrder, Velocity, encode_order
from swarm_msgs_py.geometry.solids.barriers import OPEN_SPACE, Barriers
from swarm_msgs_py.geometry.solids.description import packed_description
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.metrics.covering import Covering
from swarm_sim.points.config import PointSimConfig
from swarm_sim.points.simulation import PointScene, PointSimulation

Event = Callable[["CoverageMission"], None]


@dataclass(frozen=True, slots=True)
class CoverageOutcome:
    """What one mission came to.

    Attributes
    ----------
    is_complete : bool
        Whether it ended by itself, with no place left to fill.
    placed : int
        Followers that hold a place at the end.
    rendezvous_s, approach_s, expansion_s : float
        Simulated time of each part [s]; the expansion ends when the last robot switches its sensor on.
    violations : int
        Ticks in which the live robots were not one component by links strictly shorter than r_sc.
    ticks, frames, frame_bytes : int
    positions : (p, 3) array
        Of the robots with sensors on, the leader first [m].
    """

    is_complete: bool
    placed: int
    rendezvous_s: float
    approach_s: float
    expansion_s: float
    violations: int
    ticks: int
    frames: int
    frame_bytes: int
    positions: FloatArray


class CoverageMission:
    """Agents and world, tick by tick.

    Parameters
    ----------
    shape : dict
        Description of the solid.
    agents : CoverageConfig
    world : PointSimConfig
    robots : int
        The leader included.
    seed : int
    newcomers : (m, 3) array, optional
        Where more robots appear [m].
    appear_at : int
        Tick in which they do.
    barriers : Barriers, optional
        Obstacles.
    """

    def __init__(  # noqa: PLR0913 - what a mission is made of
        self,
        shape: dict[str, Any],
        agents: CoverageConfig,
        world: PointSimConfig,
        robots: int,
        seed: int,
        *,
        newcomers: FloatArray | None = None,
        appear_at: int = 0,
        barriers: Barriers = OPEN_SPACE,
    ) -> None:
        starts = start_positions(robots, world.radio.range_m, seed, START_EDGE)
        late = np.empty((0, 3)) if newcomers is None else newcomers
        arrivals = {NodeId(robots + number): appear_at for number in range(len(late))}
        scene = PointScene(np.concatenate([starts, late]), LEADER, starts[0], barriers, arrivals)
        self._patience = agents.protocol.absence_ticks
        self.world = PointSimulation(world, scene, seed)
        self.agents = {
            robot: CoverageAgent(robot, agents, world.period_s, seed, is_leader=robot == LEADER, barriers=barriers)
            for robot in self.world.robots
        }
        self.watch = Covering(world.period_s)
        self._orders, self._number = list[bytes](), 0
        self._frames = self._bytes = 0
        self.order(shape=shape)

    @property
    def modes(self) -> dict[NodeId, CoverageMode]:
        """What each live robot is doing."""
        return self.watch.modes

    def run(self, ticks_max: int, event: Event | None = None) -> CoverageOutcome:
        """Run until nothing is left to do, or for `ticks_max`; `event` may interfere before each tick."""
        while self.world.tick < ticks_max and not self.watch.is_over:
            if event is not None:
                event(self)
            self.tick()
        return self.outcome()

    def order(self, *, shape: dict[str, Any] | None = None, velocity: Velocity = AT_REST) -> None:
        """Tell the leader to cover another shape, or to set the formation in motion [m/s]."""
        self._number += 1
        packed = b"" if shape is None else packed_description(shape)
        self._orders.append(encode_order(CoverageOrder(self._number, packed, velocity)))
        self.watch.expect()

    def kill(self, robots: Iterable[NodeId]) -> None:
        """End some robots; the mission goes on at least until their absence can have been noticed."""
        for robot in robots:
            self.world.kill(NodeId(robot))
        self.watch.expect(self._patience)

    def tick(self) -> None:
        """Let all live agents act once."""
        seen = self.world.observe()
        outputs = {robot: self.agents[robot].step(inputs) for robot, inputs in seen.agents.items()}
        orders, self._orders = tuple(self._orders), []
        outboxes = {robot: output.outbox for robot, output in outputs.items()} | {MISSION: orders}
        self.world.apply({robot: output.command for robot, output in outputs.items()}, outboxes)
        truth = self.world.advance()
        self._frames += truth.radio.frames
        self._bytes += truth.radio.bytes
        self.watch.take(truth, {robot: output.report for robot, output in outputs.items()})

    def outcome(self) -> CoverageOutcome:
        """Return what the mission has come to so far."""
        holders, (rendezvous, approach, expansion) = self.watch.holders, self.watch.times_s
        return CoverageOutcome(
            is_complete=self.watch.is_over,
            placed=len(holders) - (LEADER in holders),
            rendezvous_s=rendezvous,
            approach_s=approach,
            expansion_s=expansion,
            violations=self.watch.violations,
            ticks=self.world.tick,
            frames=self._frames,
            frame_bytes=self._bytes,
            positions=self.world.positions[holders],
        )
