"""From the command line of ``tracking_study.py`` to tables, a figure and an exit code."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.table import Table

from bringup.option_types import OneLineParser, choice, complain, folder, number, whole
from bringup.steady_stream import steady
from studies.campaign_folder import write_files
from studies.campaign_progress import console_on
from studies.tracking_curves import CurveKind
from studies.tracking_figure import tracking_figure
from studies.tracking_tables import (
    COMPARISON_HEADER,
    HEADER,
    as_csv,
    as_markdown,
    comparison_rows,
    score_rows,
)
from studies.tracking_trial import Scores, Track, drive, scaled_hull, scaled_weather, scores_of
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_sim.boats.config import BoatsConfig, ControllerKind
from swarm_sim.boats.firmware import make_controller

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
TABLE, CSV, FIGURE = "table.md", "table.csv", "tracking-study.png"
DEFAULT_OUT = Path("runs") / "tracking-study"
SEEDS_MAX = 1000


def main(argv: Sequence[str] | None = None) -> int:
    """Drive all boats, write what came out; return the exit code (0, 1, 2 or 130)."""
    try:
        return _study(sys.argv[1:] if argv is None else argv)
    except SwarmError as error:
        complain(error)
        return BAD_INPUT if isinstance(error, ConfigError) else FAILED
    except KeyboardInterrupt:
        print("interrupted; nothing was written", file=steady(sys.stderr))
        return INTERRUPTED


def _study(argv: Sequence[str]) -> int:
    given = _make_parser().parse_args(argv)
    controllers = [ControllerKind(name) for name in given.controllers]
    nominal, seeds = BoatsConfig(), range(given.first_seed, given.first_seed + given.seeds)
    config = replace(nominal, water=scaled_weather(nominal.water, given.weather))
    hull = scaled_hull(nominal.hull, given.body)
    tracks: dict[tuple[CurveKind, ControllerKind], Track] = {}
    results: dict[tuple[CurveKind, ControllerKind], Scores] = {}
    for curve in map(CurveKind, given.curves):
        for kind in controllers:
            track = drive(config, curve, seeds, partial(make_controller, kind), hull)
            tracks[curve, kind], results[curve, kind] = track, scores_of(track)
    given.out.mkdir(parents=True, exist_ok=True)
    write_files(
        given.out,
        {
            TABLE: as_markdown(results, given.seeds, given.body, given.weather).encode(),
            CSV: as_csv(results).encode(),
            FIGURE: tracking_figure(tracks, given.seeds),
        },
    )
    console = console_on(sys.stdout)
    for header, rows in ((HEADER, score_rows(results)), (COMPARISON_HEADER, comparison_rows(results))):
        table = Table(box=None, padding=(0, 2, 0, 0))
        for title in header:
            table.add_column(title, no_wrap=True)
        for row in rows:
            table.add_row(*row)
        console.print(table)
        console.print()
    console.print(f"results: {given.out / TABLE}, {CSV}, {FIGURE}", markup=False, soft_wrap=True)
    return DONE


def _make_parser() -> OneLineParser:
    parser = OneLineParser(prog="tracking_study.py", description=__doc__)
    names = [kind.value for kind in ControllerKind]
    parser.add_argument("--seeds", type=whole(1, SEEDS_MAX), default=20, help="boats (default: %(default)s)")
    parser.add_argument(
        "--first-seed", type=whole(0, 2**31 - 1), default=1, help="of the weather (default: %(default)s)"
    )
    parser.add_argument(
        "--controllers",
        type=choice(ControllerKind),
        nargs="+",
        default=names,
        help=f"{', '.join(names)} (default: all)",
    )
    curves = [kind.value for kind in CurveKind]
    parser.add_argument(
        "--curves", type=choice(CurveKind), nargs="+", default=curves, help=f"{', '.join(curves)} (default: both)"
    )
    parser.add_argument(
        "--body",
        type=number(0.1, 10.0),
        default=1.0,
        help="true mass, inertia and drag, relative to what the gains are for",
    )
    parser.add_argument(
        "--weather", type=number(0.1, 10.0), default=1.0, help="strength of wind, gusts and waves, relative"
    )
    parser.add_argument("--out", type=folder, default=DEFAULT_OUT, help="folder of the results (default: %(default)s)")
    return parser
