"""The same runs on a Dask cluster."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from importlib import import_module
from queue import Empty, SimpleQueue
from typing import Any

from batches.cells import Run
from batches.performing import Performed, perform
from studies.code_version import code_version
from swarm_msgs_py.errors import ConfigError, SwarmError

CONNECT_S = 10.0
"""How long a scheduler may take to answer."""

GRACE_S = 60.0
"""How long the cluster may be without any worker: at the beginning, and after its last one has gone."""

POLL_S = 1.0
"""How often the cluster is asked for its workers while no run finishes."""

AHEAD = 4
"""Runs per thread of the cluster that are handed over before results come back; the rest waits here, so that the
scheduler does not hold a million runs, and a worker that joins later is given some."""


class ClusterError(SwarmError):
    """The cluster cannot do what it is to do; what it has done is kept."""


class Cluster:
    """A Dask cluster; use as a context manager, leave it to take back what it has not finished.

    Parameters
    ----------
    address : str
        Of the scheduler.

    Raises
    ------
    ConfigError
        If there is no scheduler at that address, or the library is not installed.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        self._distributed = _library()
        # It prints tracebacks of what ends here as one line of error.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client = self._distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError):
            raise ConfigError(
                f"--scheduler {address}: no Dask scheduler answers there; start one (`dask scheduler`), or mend the "
                "address"
            ) from None

    def __enter__(self) -> Cluster:
        """Return itself; it is connected already."""
        return self

    def __exit__(self, *error: object) -> None:
        """Let go of all runs that are not finished, and of the scheduler."""
        self._client.close(timeout=CONNECT_S)

    @property
    def threads(self) -> int:
        """How many runs it can do at a time, now."""
        return sum(self._client.nthreads().values())

    def completed(self, runs: Sequence[Run]) -> Iterator[tuple[Run, Performed]]:
        """Yield runs with their results as they finish; a run whose worker dies is given to another one.

        Raises
        ------
        ClusterError
            If the cluster has had no worker for `GRACE_S`, has other code than this, lost its scheduler, or gave a
            run up.
        """
        lost = (OSError, ImportError, self._distributed.KilledWorker, self._distributed.CancelledError)
        try:
            yield from self._completed(runs)
        except lost as error:
            cause = " ".join(str(error).split()) or type(error).__name__
            raise ClusterError(f"cluster at {self._address}: {cause}; what is done is kept") from None

    def _completed(self, runs: Sequence[Run]) -> Iterator[tuple[Run, Performed]]:
        own, waiting = code_version(), list(reversed(runs))
        running: dict[Any, Run] = {}
        finished: SimpleQueue[Any] = SimpleQueue()
        alive = time.monotonic()  # when the last worker was seen
        while waiting or running:
            threads = self.threads
            if threads:
                alive = time.monotonic()
            elif time.monotonic() - alive > GRACE_S:
                raise ClusterError(
                    f"cluster at {self._address}: no worker for {GRACE_S:g} s; start some (see --help) and run the "
                    "same command again, what is done is kept"
                )
            while waiting and len(running) < AHEAD * threads:
                run = waiting.pop()
                # Not pure: equal runs of an earlier batch, perhaps of other code, must not answer from memory.
                future = self._client.submit(perform, run, pure=False)
                running[future] = run
                future.add_done_callback(finished.put)
            # Not for ever: while there is no worker nothing finishes, and nobody says so.
            try:
                future = finished.get(timeout=POLL_S)
            except Empty:
                continue
            run, result = running.pop(future), future.result()
            if result.code != own:
                raise ClusterError(f"a worker runs version {result.code} of the code, this is {own}; make them equal")
            yield run, result


def _library() -> Any:
    try:
        return import_module("distributed")
    except ImportError:
        raise ConfigError(
            "--scheduler: the library 'distributed' is not installed; run `pip install dask distributed`, "
            "or leave --scheduler out to use all cores of this machine"
        ) from None
