"""Success, time and thrust energy of assemblies in continuous space: wind, waves, docking by contact, faults.

PYTHONPATH=scripts python benchmarks/assembly_pool.py [--maps NAME ...] [--docks genderless gendered]
    [--bodies bullet|planar] [--engine inprocess|ros] [--first-seed S] [--seeds N]
    [--fault none|loss|death|docking|magnet] [--out FILE]

With ``--engine ros`` each run is started as a user would start it: a world, a mission computer and a node per boat.
Runs are made seed by seed, so that whatever ends the benchmark leaves whole seeds; with ``--out`` finished ones are
kept, and are not made again. Computing time is that of the thread in one process, and by the wall with ROS.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from time import thread_time
from typing import Any

import numpy as np
from result_file import open_results
from tables import print_head, print_row

from mission_computer.assembly.map_library import load_problem, map_names
from mission_computer.assembly.planner import TimedPlannerLimits, plan_with_timed_paths
from studies.pool_assembly import Faults, assemble_in_pool, is_built, with_random_turns
from swarm_msgs_py.assembly.faces import Face, Gender
from swarm_msgs_py.assembly.plan import AssemblyPlan
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.randomness import rng_for
from swarm_sim.boats.config import CELL_M
from swarm_sim.boats.pool import BodyKind

LAUNCHER = Path(__file__).resolve().parents[1] / "scripts" / "launch_swarm.py"
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


Numbers = dict[str, Any]
"""What is kept of a run: built, boats, wanted, violations, time_s, energy_n2s, computing_s."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table and return the exit code: 1 if a run did something it must not."""
    given = _parser().parse_args(arguments)
    try:
        file = open_results(given.out)
    except ConfigError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    rows: dict[tuple[str, Gender], list[Numbers]] = {}
    keys = []
    for seed in range(given.first_seed, given.first_seed + given.seeds):
        for name in given.maps:
            for gender in given.docks:
                keys.append(f"{given.engine}, {given.bodies.value}, {given.fault}, {name}, {gender.value}, seed {seed}")
                if keys[-1] not in file.records:
                    file.append(keys[-1], _run(name, gender, seed, given))
                rows.setdefault((name, gender), []).append(dict(file.records[keys[-1]]))
    _print(rows)
    if warning := file.warning(keys):
        print(f"\n**{warning}**")
    is_clean = not any(run["violations"] for runs in rows.values() for run in runs)
    return 0 if is_clean or given.fault != "none" else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--maps", nargs="+", default=list(SHAPES), choices=map_names(), help="default: five shapes")
    parser.add_argument("--docks", type=Gender, nargs="+", default=list(Gender), help="default: both")
    parser.add_argument("--bodies", type=BodyKind, choices=list(BodyKind), default=BodyKind.BULLET)
    parser.add_argument("--engine", choices=("inprocess", "ros"), default="inprocess")
    parser.add_argument("--first-seed", type=int, default=0, help="default: %(default)s")
    parser.add_argument("--seeds", type=int, default=20, help="runs per row (default: %(default)s)")
    parser.add_argument("--fault", choices=sorted(FAULTS), default="none", help="default: %(default)s")
    parser.add_argument("--out", type=Path, help="file of runs, one line of JSON each")
    return parser


def _run(name: str, gender: Gender, seed: int, given: argparse.Namespace) -> Numbers:
    began = thread_time()
    problem = load_problem(name, gender)
    if name in SHAPES:
        problem = with_random_turns(problem, seed)
    plan = plan_with_timed_paths(problem, seed, TimedPlannerLimits())
    faults = FAULTS[given.fault](problem, plan, seed)
    if given.engine == "ros":
        return _launched(name, gender, seed, given.bodies, faults)
    outcome = assemble_in_pool(problem, plan, seed, given.bodies, faults)
    return {
        "built": is_built(outcome),
        "boats": outcome.report.built,
        "wanted": outcome.report.wanted,
        "violations": list(outcome.audit.violations),
        "note": outcome.report.note,
        "time_s": outcome.time_s,
        "energy_n2s": outcome.energy_n2s,
        "computing_s": thread_time() - began,
    }


def _launched(name: str, gender: Gender, seed: int, bodies: BodyKind, faults: Faults) -> Numbers:
    """Return a run of the ROS engine, with a node per boat."""
    events: list[dict[str, Any]] = [{"at_s": when, "kill": [boat]} for boat, when in faults.deaths.items()]
    events += [
        {"at_s": when, "magnets": [{"boat": boat, "side": face.name.lower()}]}
        for (boat, face), when in faults.magnets.items()
    ]
    settings = {
        "map.name": name,
        "map.docks": gender.value,
        "map.random_turns": name in SHAPES,
        "events": events,
        "sim.bodies": bodies.value,
        "sim.radio.loss": faults.frame_loss,
    }
    words = ["--scenario", "assembly-s", "--engine", "ros", "--seed", str(seed), "--json"]
    for key, value in settings.items():
        words += ["--set", f"{key}={json.dumps(value)}"]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, str(LAUNCHER), *words, "--out", str(Path(folder) / "run")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if not done.stdout:
        raise RuntimeError(f"{' '.join(command)} ended with {done.returncode}: {done.stderr[-2000:]}")
    metrics = json.loads(done.stdout)
    violations = [f"{metrics[what]} {what}" for what in ("collisions", "docks_torn") if metrics[what]]
    return {
        "built": metrics["achieved"] and not violations,
        "boats": metrics["filled_places"],
        "wanted": metrics["places"],
        "violations": violations,
        "note": metrics["reason"],
        "time_s": metrics["sim_time_s"],
        "energy_n2s": metrics["thrust_energy_n2s"],
        "computing_s": metrics["wall_time_s"],
    }


def _print(rows: dict[tuple[str, Gender], list[Numbers]]) -> None:
    print_head(
        [
            *("map", "docks", "built", "boats in the structure, mean (least) of", "violations", "time [s] mean (max)"),
            *("energy", "computing [s]"),
        ]
    )
    for (name, gender), runs in rows.items():
        boats, times = ([run[key] for run in runs] for key in ("boats", "time_s"))
        print_row(
            [
                *(name, gender.value),
                f"{sum(run['built'] for run in runs)} of {len(runs)}",
                f"{np.mean(boats):.1f} ({min(boats)}) of {runs[0]['wanted']}",
                f"{sum(len(run['violations']) for run in runs)}",
                f"{np.mean(times):.1f} ({max(times):.1f})",
                f"{np.mean([run['energy_n2s'] for run in runs]):.0f}",
                f"{np.mean([run['computing_s'] for run in runs]):.1f}",
            ]
        )


if __name__ == "__main__":
    raise SystemExit(main())
