"""Many independent runs on all cores, with a file of results that survives whatever ends the campaign."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TypeVar

from swarm_msgs_py.errors import ConfigError, SwarmError

Record = Mapping[str, object]
ORPHANED = 1  # exit code of a worker whose parent died
RunT = TypeVar("RunT")
ResultT = TypeVar("ResultT")


class WorkerDiedError(SwarmError):
    """A worker process ended in the middle of a run: killed, or out of memory."""


class ResultFile:
    """One line of JSON per finished run; appended to as runs finish, so that nothing that was done gets lost.

    Parameters
    ----------
    path : Path or None
        May be missing; its folder must exist. None: nothing is kept.
    version : str
        Of the code that runs now; it is noted with each result.

    Raises
    ------
    ConfigError
        If the file cannot be read.
    """

    def __init__(self, path: Path | None, version: str) -> None:
        self.path = path
        self._version = version
        self.records: dict[str, Record] = {}
        """Results by key of run, the last one of each; a line that a crash cut off counts as none."""
        self.versions: dict[str, str] = {}
        """Version of the code that made each result."""
        try:
            text = path.read_text(encoding="utf-8") if path is not None and path.exists() else ""
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigError(f"{path}: cannot be read ({error}); give another --out, or remove the file") from None
        self._is_cut_off = bool(text) and not text.endswith("\n")
        for line in text.splitlines():
            try:
                entry = json.loads(line)
                key, code, result = str(entry["run"]), str(entry["code"]), dict(entry["result"])
            except (ValueError, KeyError, TypeError):
                continue
            self._keep(key, code, result)

    @property
    def outdated(self) -> set[str]:
        """Keys of the results that other code made."""
        return {key for key, version in self.versions.items() if version != self._version}

    def append(self, key: str, record: Record) -> None:
        """Add a result and write it through."""
        self._keep(key, self._version, record)
        if self.path is None:
            return
        entry = {"run": key, "code": self._version, "result": record}
        with self.path.open("a", encoding="utf-8") as file:
            file.write(("\n" if self._is_cut_off else "") + json.dumps(entry) + "\n")
        self._is_cut_off = False

    def warning(self, runs: Iterable[str]) -> str:
        """Return what to say of those of the named runs whose results other code made; nothing if there are none."""
        outdated = self.outdated
        count = sum(run in outdated for run in runs)
        if not count:
            return ""
        return f"warning: {count} of the results in {self.path} were made by other code; remove the file to start anew"

    def _keep(self, key: str, version: str, record: Record) -> None:
        self.records[key] = record
        self.versions[key] = version


def completed(runs: Sequence[RunT], perform: Callable[[RunT], ResultT], workers: int) -> Iterator[tuple[RunT, ResultT]]:
    """Yield runs with their results as they finish; leaving the iteration early ends all workers at once.

    Parameters
    ----------
    runs : sequence
        Picklable.
    perform : callable
        A function of a module; its result must not depend on the process it runs in, nor on earlier runs.
    workers : int
        Processes; 1 for this one.

    Raises
    ------
    WorkerDiedError
        If a worker process was ended from outside.
    """
    if workers == 1 or len(runs) < 2:
        for run in runs:
            yield run, perform(run)
        return
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(
        min(workers, len(runs)), mp_context=multiprocessing.get_context("spawn"), initializer=_begin_worker
    )
    running: dict[Future[ResultT], RunT] = {}
    waiting = list(reversed(runs))
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                run = waiting.pop()
                running[pool.submit(perform, run)] = run
            finished, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                yield running.pop(future), future.result()
    except BrokenProcessPool:
        raise WorkerDiedError(
            "a worker process died; run the same command again to go on, perhaps with fewer"
        ) from None
    finally:
        # What still runs is not wanted any more, and may take a while; workers themselves never hear of a Ctrl-C.
        for child in set(multiprocessing.active_children()) - before if running else ():
            child.terminate()
        pool.shutdown(wait=True, cancel_futures=True)


def _begin_worker() -> None:
    """Leave Ctrl-C to the parent, and end when it dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(ORPHANED)
