"""The command line of ``lps_study.py``."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import TypeVar

from bringup.option_types import OneLineParser, choice, folder, number, whole
from studies.lps_cells import Design, Experiment, Motion, SweepKind, Trial
from swarm_agent.localization.config import LpsMode
from swarm_msgs_py.errors import ConfigError

ALL = "all"
SEED_MAX = 2**32 - 1
DEFAULT_OUT = Path("runs") / "lps-study"
ROBOTS_MIN = 3  # one per type of the thesis
_KindT = TypeVar("_KindT", bound=Enum)


@dataclass(frozen=True, slots=True)
class Arguments:
    """What the operator asked for.

    Attributes
    ----------
    design : Design
    trial : Trial
    seeds : range
    workers : int
        Processes that simulate.
    simulates : bool
        False: only write tables and figure of what the folder has.
    out : Path
        Folder of the results.
    """

    design: Design
    trial: Trial
    seeds: range
    workers: int
    simulates: bool
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
    trial = Trial(robots=given.agents, duration_s=given.duration, warm_up_s=given.warm_up)
    if trial.warm_up_s >= trial.duration_s:
        raise ConfigError(
            f"--warm-up {trial.warm_up_s:g}: leaves nothing of the {trial.duration_s:g} s; lower it or raise --duration"
        )
    if given.first_seed + given.seeds - 1 > SEED_MAX:
        raise ConfigError(f"--first-seed {given.first_seed}: seeds end at {SEED_MAX}; lower it")
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    return Arguments(_design(given), trial, seeds, given.workers, not given.tables_only, given.out)


def _design(given: argparse.Namespace) -> Design:
    """Return the default design, narrowed to what was named; to name values of a sweep is to ask for that sweep."""
    design = replace(Design(), motion=Motion(given.motion))
    if given.experiment != ALL:
        design = replace(design, experiments=(Experiment(given.experiment),))
    if given.modes:
        design = replace(design, modes=_members(LpsMode, given.modes))
    lists = {SweepKind.PERIOD: given.periods, SweepKind.SHARE: given.shares, SweepKind.NOISE: given.sigmas}
    if any(lists.values()):
        design = replace(design, sweeps=tuple(kind for kind, values in lists.items() if values))
    if given.periods:
        design = replace(design, periods_s=tuple(given.periods), mission_periods_s=tuple(given.periods))
    if given.shares:
        design = replace(design, shares=tuple(given.shares))
    if given.sigmas:
        design = replace(design, sigmas_m=tuple(given.sigmas))
    return design


def _make_parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="lps_study.py",
        description="Measure how well robots without position sensor know where they are, by Monte Carlo simulation: "
        "against how often they localize themselves, how many robots are beacons (carry a position sensor), how noisy "
        "ranges are, and in which mode the local positioning system (LPS) works. Prints targets and measured values; "
        "writes tables and a figure. The whole study takes hours; --seeds 2 gives a first impression in minutes.",
        epilog="A study that was stopped goes on when the same command is given again: what its folder has is not "
        "simulated twice. Examples: 'lps_study.py --seeds 2 --experiment formation --periods 0 3'; 'lps_study.py "
        "--modes cooperative --shares 0.1 0.2 --out runs/shares'. Exit code 0: done (whether or not targets are met); "
        "1: a worker or the disk failed; 2: bad input; 130: interrupted, what was done is kept.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--experiment", metavar="E", type=choice(Experiment, ALL), default=ALL,
        help="formation: robots stand in a shape and only localize; mission: the whole system forms a shape; "
        "or all (default)")  # fmt: skip
    add("--modes", metavar="MODE", nargs="+", type=choice(LpsMode),
        help=f"of {', '.join(mode.value for mode in LpsMode)} (default: all; missions take the last one)")  # fmt: skip
    add("--periods", metavar="S", nargs="+", type=number(0.0, 600.0),
        help="localization periods to compare [s], 0: each control tick (default: 0 3 5 8; missions: 0 3)")  # fmt: skip
    add("--shares", metavar="P", nargs="+", type=number(0.0, 1.0),
        help="beacon shares to compare, 0 to 1 (default: 0.06 0.1 0.15 0.2 0.3 0.5)")  # fmt: skip
    add("--sigmas", metavar="M", nargs="+", type=number(0.01, 100.0),
        help="standard deviations of a range to compare [m] (default: 0.5 1 2 3 4)")  # fmt: skip
    add("--motion", metavar="MOTION", type=choice(Motion), default=Motion.REST.value,
        help="in a formation: rest, parked (knowing that they rest) or wander (default: %(default)s)")  # fmt: skip
    add("--seeds", metavar="N", type=whole(1, 100_000), default=30, help="runs per cell (default: %(default)s)")
    add("--first-seed", metavar="S", type=whole(0, SEED_MAX), default=1, help="default: %(default)s")
    add("--agents", metavar="N", type=whole(ROBOTS_MIN, 1000), default=50,
        help="number of robots (default: %(default)s)")  # fmt: skip
    add("--duration", metavar="S", type=number(1.0, 1e5), default=180.0,
        help="simulated time of a run of experiment formation [s] (default: %(default)g)")  # fmt: skip
    add("--warm-up", metavar="S", type=number(0.0, 1e5), default=60.0,
        help="of it, what does not count [s] (default: %(default)g)")  # fmt: skip
    add("--workers", metavar="K", type=whole(1, 1024), default=os.cpu_count() or 1,
        help="processes that simulate; the numbers do not depend on it (default: all cores)")  # fmt: skip
    add("--tables-only", action="store_true", help="simulate nothing; write tables and figure of what the folder has")
    add("--out", metavar="DIR", type=folder, default=DEFAULT_OUT, help="folder of the results (default: %(default)s)")
    return parser


def _members(kind: type[_KindT], values: Sequence[str]) -> tuple[_KindT, ...]:
    """Return the named members of an enumeration, each once, in its own order."""
    return tuple(member for member in kind if member.value in values)
