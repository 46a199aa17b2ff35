"""From the command line of ``camera_study.py`` to a table and an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from bringup.interruption import Interruption
from bringup.option_types import OneLineParser, complain, folder, whole
from bringup.steady_stream import steady
from studies.camera_runs import Run, perform
from studies.camera_scores import as_markdown, scores_of, target_rows, total
from studies.campaign import completed
from studies.campaign_folder import open_results, write_files
from studies.campaign_progress import console_on, follow
from swarm_msgs_py.errors import ConfigError, SwarmError
from swarm_sim.config import Renderer

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
TABLE = "table.md"
DEFAULT_OUT = Path("runs") / "camera-study"
TUNING_SEEDS = 10_000
"""Seeds below this were, and are, for tuning; the study begins here."""
SEED_MAX = 2**32 - 1


@dataclass(frozen=True, slots=True)
class Arguments:
    """What the operator asked for.

    Attributes
    ----------
    runs : tuple of Run
    workers : int
        Processes.
    out : Path
        Folder of the results.
    """

    runs: tuple[Run, ...]
    workers: int
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
    parser = OneLineParser(
        prog="camera_study.py",
        description="Measure how well the mission computer finds the five robots of the table-top arena in images of "
        "the overhead camera: errors of positions and headings, robots that are not found, false identities, and the "
        "time per image. Every seed is another camera, light, lens and noise; images show robots anywhere, robots that "
        "touch, robots partly out of view or missing, spots in their colors, look-alikes of robots that were seen a "
        "moment before, and a half that is black.",
        epilog="A study that was stopped goes on when the same command is given again. Exit code 0: done (whether or "
        "not targets are met); 1: a worker or the disk failed; 2: bad input; 130: interrupted, what was done is kept.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("--seeds", metavar="N", type=whole(1, 100_000), default=100, help="cameras (default: %(default)s)")
    add("--images", metavar="N", type=whole(1, 100_000), default=100, help="images of each (default: %(default)s)")
    add("--first-seed", metavar="S", type=whole(0, SEED_MAX), default=TUNING_SEEDS,
        help="default: %(default)s; smaller ones are for tuning")  # fmt: skip
    add("--renderer", choices=[renderer.value for renderer in Renderer], default=Renderer.RASTER.value,
        help="what draws the images, as camera.renderer of a scenario (default: %(default)s)")  # fmt: skip
    add("--workers", metavar="K", type=whole(1, 1024), default=os.cpu_count() or 1,
        help="processes; the numbers do not depend on it, but for the time (default: all cores)")  # fmt: skip
    add("--out", metavar="DIR", type=folder, default=DEFAULT_OUT, help="folder of the results (default: %(default)s)")
    given = parser.parse_args(argv)
    last = given.first_seed + given.seeds - 1
    if last > SEED_MAX:
        raise ConfigError(f"--first-seed {given.first_seed}: seeds end at {SEED_MAX}; lower it")
    renderer = Renderer(given.renderer)
    runs = tuple(Run(seed, given.images, renderer) for seed in range(given.first_seed, last + 1))
    return Arguments(runs, given.workers, given.out)


def main(argv: Sequence[str] | None = None) -> int:
    """Take and read what is missing of the images, write what there is; return the exit code (0, 1, 2 or 130)."""
    with Interruption() as interruption:
        try:
            return _study(parse_arguments(sys.argv[1:] if argv is None else argv), interruption)
        except SwarmError as error:
            complain(error)
            return BAD_INPUT if isinstance(error, ConfigError) else FAILED
        except KeyboardInterrupt:
            print("interrupted before the start; nothing was written", file=steady(sys.stderr))
            return INTERRUPTED


def _study(arguments: Arguments, interruption: Interruption) -> int:
    file = open_results(arguments.out)
    warning = file.warning(run.key for run in arguments.runs)
    missing = [run for run in arguments.runs if run.key not in file.records]
    try:
        follow(
            completed(missing, perform, arguments.workers),
            lambda run, scores: file.append(run.key, scores.as_record()),
            done=len(arguments.runs) - len(missing),
            total=len(arguments.runs),
            where=f"{arguments.workers} at a time",
            label=lambda run: f"seed {run.seed}",
            interruption=interruption,
        )
    except KeyboardInterrupt:
        pass
    except OSError as error:
        raise SwarmError(f"{file.path}: cannot be written ({error.strerror}); what it has is kept") from None
    done = [scores_of(file.records[run.key]) for run in arguments.runs if run.key in file.records]
    scores = total(done)
    write_files(arguments.out, {TABLE: as_markdown(scores, len(done), warning).encode()})
    console = console_on(sys.stdout)
    for name, target, value, met in target_rows(scores):
        console.print(f"{name:<46}{target:>16}{value:>14}  {met}", markup=False)
    if warning:
        console.print(warning, markup=False, soft_wrap=True)
    console.print(f"results: {arguments.out / TABLE}", markup=False, soft_wrap=True)
    return INTERRUPTED if interruption.requested else DONE
