"""The command line of ``launch_swarm.py``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from bringup.family import Kind
from bringup.kinds import KINDS
from bringup.option_types import OneLineParser, choice, folder, whole
from bringup.scenario_file import (
    ROBOT_COUNT,
    Override,
    family_of,
    parse_assignment,
    scenario_names,
)
from mission_computer.shape.library import suggestion
from swarm_msgs_py.errors import ConfigError
from swarm_sim.config import Backend

DEMO = "demo"
LIVE_PORT = 8765  # Foxglove's own default
SEED_MAX = 2**32 - 1


class EngineKind(Enum):
    """Ways to run the actors."""

    ROS = "ros"
    INPROCESS = "inprocess"


class Task(Enum):
    """What the launcher is to do."""

    RUN = "run"
    EXPLAIN = "explain"
    LIST = "list"


@dataclass(frozen=True, slots=True)
class Arguments:
    """What the operator asked for.

    Attributes
    ----------
    task : Task
        Run the scenario, print it in full, or list the ready-made ones.
    scenario : str
        Name of a ready-made scenario, or a file.
    overrides : tuple of Override
        Settings on top of the scenario.
    engine : EngineKind
    agents_per_process : int or None
        None for what was measured best.
    real_time : bool
        Pace ticks by the wall clock.
    record : bool
        Record all topics into the run folder.
    dashboard : bool
        Show every robot in the terminal while the run goes on.
    live : int or None
        Port on which the run is shown to Foxglove, None for not at all.
    out : Path or None
        Folder for the results, None for a new one under ``runs/``.
    json : bool
        Print the metrics, and nothing else, on standard output.
    show : bool
        Film what the overhead camera sees.
    """

    task: Task
    scenario: str
    overrides: tuple[Override, ...]
    engine: EngineKind
    agents_per_process: int | None
    real_time: bool
    record: bool
    dashboard: bool
    live: int | None
    out: Path | None
    json: bool
    show: bool = False


def parse_arguments(argv: Sequence[str]) -> Arguments:
    """Return what the operator asked for.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    SystemExit
        With code 0, after ``--help``.
    """
    parser = _make_parser()
    given = parser.parse_args(argv)
    engine = EngineKind(given.engine)
    if given.record and engine is not EngineKind.ROS:
        raise ConfigError("--record: only the ros engine has topics to record; leave it out or use --engine ros")
    if given.agents_per_process is not None and engine is not EngineKind.ROS:
        raise ConfigError("--agents-per-process: only the ros engine has processes; leave it out or use --engine ros")
    return Arguments(
        task=Task.LIST if given.list_scenarios else Task.EXPLAIN if given.explain else Task.RUN,
        scenario=given.scenario,
        overrides=_overrides(given),
        engine=engine,
        agents_per_process=given.agents_per_process,
        real_time=given.real_time,
        record=given.record,
        dashboard=given.dashboard,
        live=given.live,
        out=given.out,
        json=given.json,
        show=given.show,
    )


def _make_parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="launch_swarm.py",
        description="Run a swarm: it forms a shape, on ROS 2 or in this process, and leaves a folder of results.",
        epilog=f"Ready-made scenarios: {', '.join(scenario_names())}. Exit code 0: mission achieved; 1: not achieved; "
        "2: bad input, nothing was started; 130: interrupted, what was recorded is kept.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--scenario", metavar="NAME|FILE", default=DEMO, help="what to run (default: %(default)s)")
    add("--shape", metavar="NAME|FILE|text:TEXT",
        help="form this shape instead of the scenario's: of the library, from GeoJSON, SVG, a picture or points, or a "
        "text; scripts/shape.py previews it")  # fmt: skip
    add("--map", metavar="NAME|FILE", help="in this arena instead of the scenario's")
    methods = "; ".join(f"{family.value}: {', '.join(kind.methods)}" for family, kind in KINDS.items())
    add("--method", metavar="M", help=f"how the shape is formed ({methods})")
    add("--agents", metavar="N", type=whole(1, 1000), help="number of robots; keeps the mix of types")
    add("--seed", metavar="S", type=whole(0, SEED_MAX), help="seed of everything that is drawn")
    add("--engine", metavar="ENGINE", type=choice(EngineKind), default=EngineKind.ROS.value,
        help="ros or inprocess (default: %(default)s)")  # fmt: skip
    add("--physics", metavar="BACKEND", type=choice(Backend), help="bullet or massdamper")
    add("--agents-per-process", metavar="K", type=whole(1, 1000), help="agent nodes in one operating-system process")
    add("--real-time", action="store_true", help="pace ticks by the wall clock")
    add("--record", action="store_true", help="record all topics into DIR/recording (MCAP)")
    add("--show", action="store_true", help="film what the overhead camera sees, as camera.mp4 in the run's folder")
    add("--dashboard", action="store_true",
        help="show every robot in the terminal: mode, distance to its goal, localization error, links")  # fmt: skip
    add("--live", metavar="PORT", nargs="?", const=LIVE_PORT, type=whole(0, 65535),
        help="show the run in a browser: Foxglove opens ws://localhost:PORT (default: %(const)s)")  # fmt: skip
    add("--out", metavar="DIR", type=folder, help="new or empty folder (default: runs/<time>-<scenario>-<seed>)")
    add("--list-scenarios", action="store_true", help="list the ready-made scenarios, and end")
    add("--explain", action="store_true",
        help="print the scenario, resolved: every setting with its unit and meaning; and end")  # fmt: skip
    add("--json", action="store_true", help="print the metrics, and nothing else, on standard output")
    add("--set", metavar="KEY=VALUE", action="append", default=[],
        help="change one setting of the scenario; the end of its key is enough where it is unique")  # fmt: skip
    return parser


def _overrides(given: argparse.Namespace) -> tuple[Override, ...]:
    """Return the overrides in a fixed order; ``--set`` comes last, being the most particular."""
    overrides: list[Override] = []
    kind = KINDS[family_of(given.scenario)]
    if given.shape is not None:
        overrides.append(kind.shape_override(given.shape))
    if given.map is not None:
        overrides.append(kind.map_override(given.map))
    if given.method is not None:
        overrides += kind.method_overrides(_method(kind, given.method))
    if given.agents is not None:
        overrides.append(Override(f"--agents {given.agents}", ROBOT_COUNT, given.agents))
    if given.seed is not None:
        overrides.append(Override(f"--seed {given.seed}", "seed", given.seed))
    if given.physics is not None:
        overrides.append(kind.physics_override(given.physics))
    return (*overrides, *(parse_assignment(text, kind.scenario) for text in given.set))


def _method(kind: Kind, name: str) -> str:
    """Return a method of the scenario's family.

    Raises
    ------
    ConfigError
        If it is none, with the nearest one.
    """
    if name not in kind.methods:
        raise ConfigError(f"--method: there is no '{name}'; {suggestion(name, kind.methods)}")
    return name
