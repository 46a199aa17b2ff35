"""Whole assemblies in a pool: timed guideposts, LADRC under wind and waves, docking by contact, frames by radio."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mission_computer.assembly.desk import AssemblyDesk, DeskConfig
from mission_computer.assembly.foreman import ForemanReport, ForemanState
from swarm_agent.assembly.agent import AssemblyAgent
from swarm_agent.assembly.steering import SkipperConfig
from swarm_msgs_py.assembly.faces import QUARTER_TURNS, Face, turned
from swarm_msgs_py.assembly.plan import AssemblyPlan, Dispatch
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.randomness import rng_for
from swarm_msgs_py.types import MISSION, FloatArray, NodeId
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.pool import BodyKind, Fleet, LatchEvent
from swarm_sim.boats.simulation import BoatSimConfig, BoatSimulation, PoolScene, PoolTruth
from swarm_sim.config import RadioConfig
from swarm_sim.metrics.docking import DockingAudit, audit_docking

TIME_FACTOR, TIME_EXTRA_S = 8.0, 60.0
"""A run may take this many times what its steps take at cruising speed, and this much more [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """What goes wrong in a run.

    Attributes
    ----------
    frame_loss : float
        Share of frames that a receiver does not get.
    deaths : mapping of int to float
        When the computer of a boat dies [s].
    magnets : mapping of (int, Face) to float
        When the magnet on a side of a boat fails [s].
    """

    frame_loss: float = 0.0
    deaths: Mapping[int, float] = field(default_factory=dict)
    magnets: Mapping[tuple[int, Face], float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class PoolOutcome:
    """One assembly in the pool.

    Attributes
    ----------
    audit : DockingAudit
    report : ForemanReport
        The last one.
    time_s : float
        Until the structure stood, or the run was given up.
    energy_n2s : float
        Integral of the squared thrusts of all boats, sampled at every tick [N^2 s].
    track : (k, n, 2) array
        True positions at every tick [m].
    """

    audit: DockingAudit
    report: ForemanReport
    time_s: float
    energy_n2s: float
    track: FloatArray


def with_random_turns(problem: AssemblyProblem, seed: int) -> AssemblyProblem:
    """Return a problem whose boats start at random quarter turns, as in the paper's experiments."""
    turns = rng_for(seed, "initial orientation").integers(QUARTER_TURNS, size=problem.boat_count).tolist()
    layouts = tuple(turned(layout, turn) for layout, turn in zip(problem.layouts, turns, strict=True))
    return replace(problem, layouts=layouts)


def start_poses(problem: AssemblyProblem) -> FloatArray:
    """Return where boats start (n, 3): at the centers of their cells, heading 0."""
    return np.column_stack([CELL_M * np.array(problem.starts, dtype=np.float64), np.zeros(problem.boat_count)])


def assemble_in_pool(
    problem: AssemblyProblem, plan: AssemblyPlan, seed: int, kind: BodyKind, faults: Faults | None = None
) -> PoolOutcome:
    """Return an assembly by boats that follow a timed plan, or find their ways by themselves.

    Parameters
    ----------
    problem : AssemblyProblem
    plan : AssemblyPlan
        With timed paths or guideposts.
    seed : int
        Of wind, waves, noise and radio.
    kind : BodyKind
    faults : Faults, optional
    """
    faults = faults or Faults()
    config = BoatSimConfig(bodies=kind, radio=RadioConfig(loss=faults.frame_loss))
    world = _world(config, problem, seed, faults)
    agents = {robot: AssemblyAgent(robot, SkipperConfig(), config.period_s) for robot in world.robots}
    desk = AssemblyDesk(DeskConfig(), problem, plan, seed, config.period_s)
    steps = plan.paths.steps if plan.paths else 2 * plan.dispatch.longest_travel(problem)
    limit_s = TIME_FACTOR * steps * CELL_M / SkipperConfig().cruise_mps + TIME_EXTRA_S
    truths: list[PoolTruth] = []
    try:
        while not desk.is_over and world.time < limit_s:
            truths.append(_tick(world, agents, desk))
        events = world.events
    finally:
        world.close()
    assert desk.report is not None  # at least one tick was made
    return PoolOutcome(
        audit=_audit(problem, desk, events, truths[-1]),
        report=desk.report,
        time_s=world.time,
        energy_n2s=sum(truth.energy_n2s for truth in truths),
        track=np.array([truth.ends for truth in truths]),
    )


def is_built(outcome: PoolOutcome) -> bool:
    """Return whether the whole structure stands and nothing went wrong on the way."""
    report = outcome.report
    return report.state is ForemanState.DONE and report.built == report.wanted and outcome.audit.is_complete_and_clean


def _world(config: BoatSimConfig, problem: AssemblyProblem, seed: int, faults: Faults) -> BoatSimulation:
    def tick_of(time_s: float) -> int:
        return round(time_s / config.period_s)

    middle = CELL_M * (np.array(problem.origin) + 0.5 * (np.array(problem.size) - 1.0))
    magnets = {(NodeId(boat), face): tick_of(when) for (boat, face), when in faults.magnets.items()}
    scene = PoolScene(Fleet(start_poses(problem), problem.layouts, problem.gender), middle, magnets)
    deaths = {NodeId(boat): tick_of(when) for boat, when in faults.deaths.items()}
    return BoatSimulation(config, scene, seed, deaths)


def _tick(world: BoatSimulation, agents: Mapping[NodeId, AssemblyAgent], desk: AssemblyDesk) -> PoolTruth:
    seen = world.observe()
    orders = desk.step(seen.mission)
    answers = {robot: agents[robot].step(inputs) for robot, inputs in seen.agents.items()}
    outboxes = {robot: answer.outbox for robot, answer in answers.items()} | {MISSION: orders.outbox}
    world.apply({robot: answer.command for robot, answer in answers.items()}, outboxes)
    return world.advance()


def _audit(
    problem: AssemblyProblem, desk: AssemblyDesk, events: tuple[LatchEvent, ...], last: PoolTruth
) -> DockingAudit:
    """Return the judgment, with all turns counted from the start."""
    turns = np.zeros(problem.boat_count, dtype=np.int64)
    plans: list[tuple[AssemblyProblem, Dispatch]] = []
    for wanted, plan in desk.plans:
        boats = list(plan.dispatch.boats)
        turns[boats] += plan.dispatch.turns
        since_start = replace(plan.dispatch, turns=tuple(turns[boats].tolist()))
        plans.append((replace(wanted, layouts=problem.layouts), since_start))
    return audit_docking(plans, events, last.overlaps)
