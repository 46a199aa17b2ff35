"""Whole assemblies on the grid: planned, driven, judged."""

from __future__ import annotations

from dataclasses import dataclass

from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from swarm_agent.assembly.boat import Boat, BoatInputs
from swarm_agent.assembly.crew import Orders
from swarm_agent.assembly.pilot import PilotConfig
from swarm_msgs_py.assembly.boat_frames import BoatFrame, Phase
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError
from swarm_msgs_py.randomness import rng_for
from swarm_sim.assembly.grid_world import GridWorld
from swarm_sim.metrics.assembly import AssemblyAudit, audit_assembly

STEPS_MAX = 1000
"""A run that takes longer has failed (simulator of the paper)."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One assembly.

    Attributes
    ----------
    plan : AssemblyPlan
    audit : AssemblyAudit
    """

    plan: AssemblyPlan
    audit: AssemblyAudit


def assemble_timed(problem: AssemblyProblem, seed: int, limits: TimedPlannerLimits) -> Outcome:
    """Return an assembly by timed guideposts: the default mode.

    Raises
    ------
    NoDispatchError
        If there is no plan.
    """
    plan = plan_with_timed_paths(problem, seed, limits)
    if plan.paths is None:
        raise AssemblyError(f"{problem.name}: a timed plan without paths")
    return Outcome(plan, audit_assembly(problem, plan.dispatch, plan.paths.cells))


def assemble_decentralized(
    problem: AssemblyProblem, plan: AssemblyPlan, seed: int, frame_loss: float = 0.0, steps_max: int = STEPS_MAX
) -> Outcome:
    """Return an assembly in which every boat finds its way by itself: the published rules.

    Parameters
    ----------
    problem : AssemblyProblem
    plan : AssemblyPlan
        With guideposts.
    seed : int
        Of the radio.
    frame_loss : float
        Share of frames that a receiver does not get.
    steps_max : int
        The run ends here if the structure is not complete.
    """
    if plan.guideposts is None:
        raise AssemblyError(f"{problem.name}: boats need guideposts to find their ways")
    config = PilotConfig()
    orders = Orders(problem, plan.dispatch, plan.tree, plan.guideposts)
    radio = rng_for(seed, "radio")
    world = GridWorld(problem, plan.dispatch, config.perception_radius_cells, frame_loss, radio)
    boats = {boat: Boat(boat, orders, config) for boat in sorted(plan.dispatch.boats)}
    frames: list[BoatFrame] = []
    for step in range(steps_max):
        outputs = {}
        for phase in Phase:
            outputs = {
                number: boat.step(
                    BoatInputs(step, phase, world.cells[number], world.seen(number), world.heard(number, frames))
                )
                for number, boat in boats.items()
            }
            frames = [said.frame for said in outputs.values() if said.frame is not None]
        if all(said.node == 0 for said in outputs.values()):
            break
        world.move({number: said.move for number, said in outputs.items()})
    return Outcome(plan, audit_assembly(problem, plan.dispatch, world.track()))
