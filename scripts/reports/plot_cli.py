"""The command line of ``plot_run.py``: files of any run folder."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from bringup.option_types import OneLineParser, complain, folder, number, whole
from reports.figures import DPI, encoded, figure_names, make_figure
from reports.page import report_page
from reports.run_record import RunRecord
from swarm_msgs_py.errors import ConfigError, SwarmError

OK, BAD_INPUT, INTERRUPTED = 0, 2, 130
FIGURES, FILMS, PAGE = (".png", ".svg", ".pdf"), (".mp4", ".gif"), ".html"
KINDS = (*FIGURES, *FILMS, PAGE)
FILM_FPS, FILM_WIDTH_IN, FILM_DPI = 20, 7.0, 100


def main(argv: Sequence[str] | None = None) -> int:
    """Make what the command line asks for; return the exit code (0, 2 or 130)."""
    try:
        given = parse_arguments(sys.argv[1:] if argv is None else argv)
        record = RunRecord.load(given.run)
        for path in given.out or [given.run / "overview.pdf"]:
            _check(path, record, given.figure)
        for path in given.out or [given.run / "overview.pdf"]:
            _write(path, record, given)
            print(path)
    except SwarmError as error:
        complain(error)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    return OK


def parse_arguments(argv: Sequence[str]) -> argparse.Namespace:
    """Return what is asked for.

    Raises
    ------
    ConfigError
        One line that names the option and the remedy.
    SystemExit
        With code 0, after ``--help``.
    """
    parser = OneLineParser(
        prog="plot_run.py",
        description="Make figures (PNG, SVG, PDF), films (MP4, GIF) or the report (HTML) of a run folder.",
        epilog="Exit code 0: all files were written; 2: bad input; 130: interrupted.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("run", metavar="RUN", type=folder, help="folder that launch_swarm.py has written")
    add("--out", metavar="FILE", type=Path, action="append", default=[],
        help="file to write, by its ending .png, .svg, .pdf, .mp4, .gif or .html; may be given several times "
        "(default: RUN/overview.pdf)")  # fmt: skip
    add("--figure", metavar="NAME", default="overview",
        help="overview, arena, formation, charts, or a chart, as localization (default: %(default)s)")  # fmt: skip
    add("--at", metavar="S", type=number(0.0, 1e9), help="simulated time that a figure shows (default: the end)")
    add("--width", metavar="IN", type=number(1.0, 40.0), help="width in inches; a text column often has 3.5")
    add("--dpi", metavar="N", type=whole(30, 1200), help=f"resolution of pixels (default: {DPI}; films {FILM_DPI})")
    add("--fps", metavar="N", type=whole(1, 60), default=FILM_FPS, help="pictures per second (default: %(default)s)")
    add("--speed", metavar="X", type=number(0.01, 1e4), help="of a film: simulated seconds per second")
    return parser.parse_args(argv)


def _check(path: Path, record: RunRecord, figure: str) -> None:
    """Refuse what cannot be made, before anything is written.

    Raises
    ------
    ConfigError
    """
    if path.suffix not in KINDS:
        raise ConfigError(f"--out {path}: what kind of file is that? Name it {', '.join(KINDS[:-1])} or {KINDS[-1]}")
    if not path.parent.is_dir():
        raise ConfigError(f"--out {path}: there is no folder {path.parent}; make it first")
    if path.suffix in FIGURES and figure not in figure_names(record):
        raise ConfigError(f"--figure {figure}: not of this run; it has {', '.join(figure_names(record))}")
    if path.suffix in FILMS and not record.ticks:
        raise ConfigError(f"--out {path}: the run ended before its first tick, so there is nothing to film")


def _write(path: Path, record: RunRecord, given: argparse.Namespace) -> None:
    try:
        if path.suffix == PAGE:
            path.write_bytes(report_page(record))
        elif path.suffix in FILMS:
            from reports.film import FilmSpec, write_film  # noqa: PLC0415 - the encoder is needed for films only

            width, dpi = given.width or FILM_WIDTH_IN, given.dpi or FILM_DPI
            write_film(path, record, FilmSpec(given.fps, given.speed, width, dpi))
        else:
            figure = make_figure(record, given.figure, width_in=given.width, at_s=given.at)
            path.write_bytes(encoded(figure, path.suffix.removeprefix("."), given.dpi or DPI))
    except OSError as error:
        raise ConfigError(f"--out {path}: cannot be written ({error.strerror})") from error
