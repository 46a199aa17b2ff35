"""The command line of ``monte_carlo.py``."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from batches.cells import BACKEND, Design
from bringup.arguments import SEED_MAX
from bringup.family import Family
from bringup.formation_kind import METHODS
from bringup.option_types import OneLineParser, choice, folder, whole
from bringup.scenario_file import ROBOT_COUNT, Override, parse_assignment, scenario_names
from swarm_msgs_py.messages.bodies import Objective
from swarm_msgs_py.partition import Method
from swarm_sim.config import Backend

SEEDS_MAX = 1_000_000
DEFAULT_SCENARIO = "formation-50-ideal"
DEFAULT_SEEDS = "200"
DEFAULT_OUT = Path("runs") / "monte-carlo"


@dataclass(frozen=True, slots=True)
class Arguments:
    """What the operator asked for.

    Attributes
    ----------
    design : Design
    workers : int
        Processes of this machine that simulate.
    scheduler : str or None
        Address of the scheduler of a Dask cluster that simulates instead.
    simulates : bool
        False: only write tables and figure of what the folder has.
    keeps_outdated : bool
        Whether results that other code made count, and are not made anew.
    out : Path
        Folder of the results.
    """

    design: Design
    workers: int
    scheduler: str | None
    simulates: bool
    keeps_outdated: bool
    out: Path


def parse_arguments(argv: Sequence[str]) -> Arguments:
    """Return what the operator asked for.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    SystemExit
        With code 0, after ``--help``.
    """
    given = _make_parser().parse_args(argv)
    design = Design(
        scenarios=tuple(given.scenario),
        shapes=tuple(given.shape),
        methods=tuple(given.method),
        objectives=tuple(given.objective),
        overrides=_overrides(given),
        is_turned=given.turns,
        seeds=given.seeds,
    )
    return Arguments(design, given.workers, given.scheduler, not given.tables_only, given.keep_outdated, given.out)


def seed_range(text: str) -> range:
    """Return the seeds of ``N`` (1 to N) or ``A:B`` (A to B, both included)."""
    match = re.fullmatch(r"(?:(\d+):)?(\d+)", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"expected a count N or a range A:B, got '{text}'")
    first, last = int(match[1] or 1), int(match[2])
    if last < first or last > SEED_MAX or last - first >= SEEDS_MAX:
        raise argparse.ArgumentTypeError(
            f"expected 1 to {SEEDS_MAX} seeds of at most {SEED_MAX}, the first not after the last, got '{text}'"
        )
    return range(first, last + 1)


def _overrides(given: argparse.Namespace) -> tuple[Override, ...]:
    """Return the overrides of all runs; ``--set`` comes last, being the most particular."""
    overrides = [Override(f"--physics {given.physics}", BACKEND, given.physics)]
    if given.agents is not None:
        overrides.append(Override(f"--agents {given.agents}", ROBOT_COUNT, given.agents))
    return (*overrides, *(parse_assignment(text) for text in given.set))


def _make_parser() -> argparse.ArgumentParser:
    ready_made = scenario_names(Family.FORMATION)
    parser = OneLineParser(
        prog="monte_carlo.py",
        description="Compare methods over many random starts: every scenario with every shape, method and objective "
        "that is named, each with the same seeds, without ROS. All methods of one seed and shape start alike. Writes "
        "one table of all runs (runs.parquet), a summary (summary.md, summary.csv) and a figure (comparison.png).",
        epilog="A batch that was stopped, or killed, goes on when the same command is given again; more seeds, shapes "
        "or methods may be added: tables are of all that the folder has results of. Examples: 'monte_carlo.py --method "
        "bubble-packing voronoi --shape formation_1 formation_2 --seeds 200'; 'monte_carlo.py --seeds 201:1000 "
        "--scheduler tcp://10.0.0.1:8786' (its workers: "
        f"'PYTHONPATH=scripts dask worker ADDRESS --nthreads 1'). Ready-made scenarios: {', '.join(ready_made)}. "
        "Exit code 0: done, whatever the runs came to; 1: a worker, the cluster or the disk failed; 2: bad input, "
        "nothing was written; 130: interrupted, what was done is kept.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--scenario", metavar="NAME|FILE", nargs="+", type=_named, default=[DEFAULT_SCENARIO],
        help=f"what to run (default: {DEFAULT_SCENARIO}: exact positions, ideal radio)")  # fmt: skip
    add("--method", metavar="M", nargs="+", type=choice(Method, *METHODS[len(Method) :]), default=[],
        help=f"methods to compare, of {', '.join(METHODS)}; differences are from the first (default: the scenario's)",
    )  # fmt: skip
    add("--shape", metavar="NAME|FILE", nargs="+", type=_named, default=[],
        help="shapes to form (default: the scenario's)")  # fmt: skip
    add("--objective", metavar="O", nargs="+", type=choice(Objective), default=[],
        help="objectives of the assignment to compare, total or bottleneck (default: the scenario's)")  # fmt: skip
    add("--seeds", metavar="N|A:B", type=seed_range, default=seed_range(DEFAULT_SEEDS),
        help=f"seeds 1 to N, or A to B (default: {DEFAULT_SEEDS})")  # fmt: skip
    add("--agents", metavar="N", type=whole(1, 1000), help="number of robots; keeps the mix of types")
    add("--physics", metavar="BACKEND", type=choice(Backend), default=Backend.MASSDAMPER.value,
        help="bullet or massdamper (default: %(default)s)")  # fmt: skip
    add("--set", metavar="KEY=VALUE", action="append", default=[],
        help="change one setting of all runs; the end of its key is enough where it is unique")  # fmt: skip
    add("--turns", action="store_true",
        help="turn the shape by an angle drawn from the seed, the same for all methods, so that differences hold for "
        "more than one orientation")  # fmt: skip
    add("--workers", metavar="K", type=whole(1, 1024), default=os.cpu_count() or 1,
        help="processes that simulate; the numbers do not depend on it (default: all cores)")  # fmt: skip
    add("--scheduler", metavar="ADDRESS", type=_named, help="simulate on a Dask cluster instead, e.g. tcp://host:8786")
    add("--tables-only", action="store_true", help="simulate nothing; write tables and figure of what the folder has")
    add("--keep-outdated", action="store_true",
        help="count results that other code made, with a warning (default: make them anew)")  # fmt: skip
    add("--out", metavar="DIR", type=folder, default=DEFAULT_OUT, help="folder of the results (default: %(default)s)")
    return parser


def _named(text: str) -> str:
    if not text.strip():
        raise argparse.ArgumentTypeError("expected a name, got ''")
    return text
