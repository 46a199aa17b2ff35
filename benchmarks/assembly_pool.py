"""Success, time and thrust energy of assemblies in continuous space: wind, waves, docking by contact, faults.

PYTHONPATH=scripts python benchmarks/assembly_pool.py [--maps NAME ...] [--bodies bullet|planar] [--seeds N]
    [--fault none|loss|death|docking|magnet]
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from time import thread_time

import numpy as np

from mission_computer.assembly.map_library import load_problem, map_names
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from studies.pool_assembly import Faults, PoolOutcome, assemble_in_pool, is_built, with_random_turns
from swarm_msgs_py.assembly.faces import Face, Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.randomness import rng_for
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.pool import BodyKind

SHAPES = tuple(name for name in map_names() if name.startswith("boats_"))
CRUISE_MPS = 0.15
LOSS = 0.2


def _no_fault(_problem: AssemblyProblem, _plan: AssemblyPlan, _seed: int) -> Faults:
    return Faults()


def _loss(_problem: AssemblyProblem, _plan: AssemblyPlan, _seed: int) -> Faults:
    return Faults(frame_loss=LOSS)


def _death(_problem: AssemblyProblem, plan: AssemblyPlan, seed: int) -> Faults:
    """Return the death of a boat with a target while it is still on its own."""
    rng = rng_for(seed, "death")
    return Faults(deaths={int(rng.choice(plan.dispatch.boats)): float(rng.uniform(1.0, 8.0))})


def _docking_death(problem: AssemblyProblem, plan: AssemblyPlan, seed: int) -> Faults:
    """Return the death of a boat around the time at which it docks first."""
    rng = rng_for(seed, "docking death")
    boat = int(rng.choice(plan.dispatch.boats))
    assert plan.paths is not None
    target = plan.dispatch.boats.index(boat)
    parent = plan.tree.nodes[plan.tree.leaf_of()[target]].parent
    crew = [plan.dispatch.boats[t] for t in plan.tree.nodes[parent].targets]
    shifts = plan.paths.cells[:, crew] - np.array([problem.targets[t] for t in plan.tree.nodes[parent].targets])
    step = int(np.flatnonzero((shifts == shifts[:, :1]).all(axis=(1, 2)))[0])
    return Faults(deaths={boat: step * CELL_M / CRUISE_MPS + float(rng.uniform(-2.0, 6.0))})


def _magnet(_problem: AssemblyProblem, plan: AssemblyPlan, seed: int) -> Faults:
    """Return the failure of all magnets of a boat: none of its docks will hold."""
    boat = int(rng_for(seed, "magnet").choice(plan.dispatch.boats))
    return Faults(magnets={(boat, face): 1.0 for face in Face})


FAULTS: dict[str, Callable[[AssemblyProblem, AssemblyPlan, int], Faults]] = {
    "none": _no_fault,
    "loss": _loss,
    "death": _death,
    "docking": _docking_death,
    "magnet": _magnet,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and return the exit code: 1 if a run did something it must not."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", nargs="+", default=list(SHAPES), choices=map_names(), help="default: five shapes")
    parser.add_argument("--bodies", type=BodyKind, choices=list(BodyKind), default=BodyKind.BULLET)
    parser.add_argument("--seeds", type=int, default=20, help="runs per row (default: %(default)s)")
    parser.add_argument("--fault", choices=sorted(FAULTS), default="none", help="default: %(default)s")
    given = parser.parse_args(arguments)
    print(
        "| map | docks | built | boats in the structure, mean (least) of | violations | time [s] | energy | CPU [s] |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    is_clean = True
    for name in given.maps:
        for gender in Gender:
            began = thread_time()
            outcomes = [_run(name, gender, seed, given) for seed in range(given.seeds)]
            is_clean &= all(not outcome.audit.violations for outcome in outcomes) or given.fault != "none"
            cpu = (thread_time() - began) / given.seeds
            print(f"| {name} | {gender.value} | {_row(outcomes)} | {cpu:.1f} |", flush=True)
            for seed, outcome in enumerate(outcomes):
                for violation in outcome.audit.violations:
                    print(f"  seed {seed}: {violation}", flush=True)
    return 0 if is_clean else 1


def _run(name: str, gender: Gender, seed: int, given: argparse.Namespace) -> PoolOutcome:
    problem = load_problem(name, gender)
    if name in SHAPES:
        problem = with_random_turns(problem, seed)
    plan = plan_with_timed_paths(problem, seed, TimedPlannerLimits())
    return assemble_in_pool(problem, plan, seed, given.bodies, FAULTS[given.fault](problem, plan, seed))


def _row(outcomes: Sequence[PoolOutcome]) -> str:
    built = [outcome.report.built for outcome in outcomes]
    wanted = outcomes[0].report.wanted
    times = [outcome.time_s for outcome in outcomes]
    whole = sum(is_built(outcome) for outcome in outcomes)
    violations = sum(len(outcome.audit.violations) for outcome in outcomes)
    energy = np.mean([outcome.energy_n2s for outcome in outcomes])
    parts = (
        f"{whole} of {len(outcomes)}",
        f"{np.mean(built):.1f} ({min(built)}) of {wanted}",
        str(violations),
        f"{np.mean(times):.1f} ({max(times):.1f})",
        f"{energy:.0f}",
    )
    return " | ".join(parts)


if __name__ == "__main__":
    raise SystemExit(main())
