"""From the command line to an exit code."""

from __future__ import annotations

import importlib.util
import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import import_module
from pathlib import Path
from typing import TextIO

from rich.console import Console

from bringup.arguments import Arguments, EngineKind, Task, parse_arguments
from bringup.dashboard import Dashboard
from bringup.engine import Actors, Engine
from bringup.explanation import explain, scenario_list
from bringup.families import BEHAVIORS
from bringup.family import AnyScenario
from bringup.filming import FILM, FilmOrder
from bringup.inprocess import InProcessEngine
from bringup.interruption import Interruption
from bringup.option_types import complain
from bringup.progress import Onlooker, Progress, print_summary
from bringup.run import Run, execute, metrics_text, write_results
from bringup.run_folder import RunFolder, reserve_default
from bringup.scenario_file import load_any
from bringup.steady_stream import steady
from recording import FOLDER
from swarm_msgs_py.errors import ConfigError, PhysicsError, ShapeError, SwarmError

ACHIEVED, NOT_ACHIEVED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
WRONG_INPUT = (ConfigError, ShapeError, PhysicsError)  # the other errors are nobody's fault: a node did not come up
RUNS = Path("runs")


def main(argv: Sequence[str] | None = None) -> int:
    """Run what the command line asks for; return the exit code (0, 1, 2 or 130)."""
    with Interruption() as interruption:
        try:
            arguments = parse_arguments(sys.argv[1:] if argv is None else argv)
            if arguments.task is not Task.RUN:
                return _answer(arguments)
            with _output(arguments.json) as (stdout, console):
                return _run(arguments, interruption, stdout, console)
        except SwarmError as error:
            complain(error)
            return BAD_INPUT if isinstance(error, WRONG_INPUT) else NOT_ACHIEVED
        except KeyboardInterrupt:
            print("interrupted before the start; nothing was written", file=steady(sys.stderr))
            return INTERRUPTED


def _run(arguments: Arguments, interruption: Interruption, stdout: TextIO, console: Console) -> int:
    """Check everything, run, write.

    Raises
    ------
    SwarmError
        Before the first tick; nothing was written then.
    KeyboardInterrupt
        As long as there is nothing to keep.
    """
    with interruption.welcome():
        scenario, origin = load_any(arguments.scenario, arguments.overrides)
        _check_installation(arguments, scenario)
        behavior = BEHAVIORS[scenario.family]
        scenario = behavior.resolve(scenario, origin)
        make_engine = _engine_maker(arguments)
        actors = behavior.actors(scenario)
        if arguments.show and actors.image_hz is None:
            raise ConfigError(f"--show: '{scenario.name}' has no camera (sim.camera.is_on); leave the option out")
    folder = RunFolder(arguments.out) if arguments.out is not None else reserve_default(scenario, RUNS)
    try:
        film = None
        if arguments.show and actors.image_hz:
            film = FilmOrder(folder.path / FILM, actors.image_hz, actors.period_s)
        run = Run(scenario, arguments.engine.value, behavior.account(scenario), folder)
        dashboard = Dashboard(behavior.scenes(scenario)) if arguments.dashboard else None
        with _live_view(arguments, scenario) as live, Progress(console, dashboard, live) as progress:
            progress.say(f"{scenario.name}: {scenario.robot_count} robots, seed {scenario.seed}, {run.engine}")
            engine = make_engine(actors, film, folder.path / FOLDER if arguments.record else None)
            ended = execute(run, engine, interruption, progress)
            for note in engine.notes:
                progress.say(note)
        try:
            metrics = write_results(run, ended, interruption, progress.say)
        except OSError as error:
            print(f"error: {folder.path}: results could not be written ({error.strerror})", file=steady(sys.stderr))
            return INTERRUPTED if interruption.requested else NOT_ACHIEVED
    finally:
        folder.release()
    if arguments.json:
        stdout.write(metrics_text(metrics))
        stdout.flush()
    print_summary(console, metrics, str(folder.path))
    if interruption.requested:
        return INTERRUPTED
    return ACHIEVED if metrics.achieved else NOT_ACHIEVED


def _live_view(arguments: Arguments, scenario: AnyScenario) -> AbstractContextManager[Onlooker | None]:
    """Return what shows the run in a browser, if that was asked for; who did not ask need not wait for its library."""
    if arguments.live is None:
        return nullcontext()
    scenes = BEHAVIORS[scenario.family].scenes(scenario)
    view: AbstractContextManager[Onlooker] = import_module("bringup.live_view").LiveView(
        scenario.name, scenes, arguments.live
    )
    return view


def _answer(arguments: Arguments) -> int:
    """Print what there is to run, or what would be run.

    Raises
    ------
    SwarmError
        If the scenario is not sound.
    """
    if arguments.task is Task.LIST:
        text = scenario_list()
    else:
        scenario, origin = load_any(arguments.scenario, arguments.overrides)
        text = explain(BEHAVIORS[scenario.family].resolve(scenario, origin))
    stdout = steady(sys.stdout)
    stdout.write(text)
    stdout.flush()
    return ACHIEVED


def _check_installation(arguments: Arguments, scenario: AnyScenario) -> None:
    """Refuse what needs a library that is not there.

    Raises
    ------
    ConfigError
        Naming the option and what to install or use instead.
    """
    if arguments.engine is EngineKind.ROS and importlib.util.find_spec("rclpy") is None:
        raise ConfigError(
            "--engine ros: rclpy is not installed; run `make`, or source ROS 2, or use --engine inprocess"
        )
    BEHAVIORS[scenario.family].check_installation(scenario)


def _engine_maker(arguments: Arguments) -> Callable[[Actors, FilmOrder | None, Path | None], Engine]:
    """Return what makes the engine for some actors, a film and the folder of the recording, if there are to be any.

    Raises
    ------
    ConfigError
        If ROS is asked for and cannot be loaded.
    """
    if arguments.engine is EngineKind.INPROCESS:
        return lambda actors, film, _: InProcessEngine(actors, real_time=arguments.real_time, film=film)
    # Imported on demand: everything else must work where ROS is not installed.
    try:
        module = import_module("bringup.ros_engine")
    except ImportError as error:
        raise ConfigError(
            f"--engine ros: ROS 2 cannot be loaded ({error}); mend it or use --engine inprocess"
        ) from None

    def make(actors: Actors, film: FilmOrder | None, record_to: Path | None) -> Engine:
        engine: Engine = module.RosEngine(
            actors,
            agents_per_process=arguments.agents_per_process,
            real_time=arguments.real_time,
            record_to=record_to,
            film=film,
        )
        return engine

    return make


@contextmanager
def _output(is_json: bool) -> Iterator[tuple[TextIO, Console]]:
    """Yield where the metrics go and where everything else goes.

    With ``--json``, whatever libraries write to standard output (PyBullet greets there, from C) goes to standard error
    as well, also from child processes, so that standard output carries nothing but the metrics.
    """
    if not is_json:
        stdout = steady(sys.stdout)
        yield stdout, Console(file=stdout)
        return
    sys.stdout.flush()
    kept = os.dup(1)
    os.dup2(2, 1)
    try:
        with io.TextIOWrapper(os.fdopen(kept, "wb", closefd=False), encoding="utf-8") as stdout:
            yield steady(stdout), Console(file=steady(sys.stderr))
    finally:
        os.dup2(kept, 1)
        os.close(kept)
