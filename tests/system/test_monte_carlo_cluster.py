"""Monte Carlo batches on a Dask cluster of real processes, some of which die."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import SimpleQueue
from threading import Thread

import pytest
from pyarrow import parquet
from small_batch import DEADLINE_S, batch, entries, metrics_of
from source_tree import ROOT

from batches import cluster
from batches.cli import CSV, FIGURE, RUNS, SUMMARY
from studies.campaign import Record, ResultFile
from studies.campaign_folder import RESULTS
from studies.code_version import code_version

PLACE = ("--host", "127.0.0.1", "--no-dashboard")


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Return the address of a Dask scheduler with two worker processes."""
    own = worker_options(tmp_path_factory.mktemp("dask"))
    with ExitStack() as stack:
        address = told(stack.enter_context(dask("dask_scheduler", *PLACE, "--port", "0")), "Scheduler at:")
        workers = [stack.enter_context(dask("dask_worker", address, *PLACE, *own)) for _ in range(2)]
        for worker in workers:
            told(worker, "Registered to:")
        yield address


def test_a_cluster_makes_the_same_numbers(scheduler: str, tmp_path: Path) -> None:
    alone, out = tmp_path / "alone", tmp_path / "cluster"
    assert batch(alone, "--seeds", "2", "--workers", "1") == 0
    assert batch(out, "--seeds", "2", "--scheduler", scheduler) == 0

    assert metrics_of(out) == metrics_of(alone)
    for name in (SUMMARY, CSV, FIGURE):
        assert (out / name).read_bytes() == (alone / name).read_bytes()


def test_a_cluster_of_other_code_is_not_listened_to(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cluster, "code_version", lambda: "newer")

    assert batch(tmp_path, "--seeds", "1", "--scheduler", scheduler) == 1
    assert f"a worker runs version {code_version()} of the code, this is newer" in capsys.readouterr().err
    assert not (tmp_path / RESULTS).read_text()


def test_a_cluster_without_any_worker_is_given_up_after_a_while(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shorten(monkeypatch)
    with dask("dask_scheduler", *PLACE, "--port", "0") as scheduler:
        assert batch(tmp_path, "--seeds", "1", "--scheduler", told(scheduler, "Scheduler at:")) == 1

    assert "no worker for 0.2 s; start some" in capsys.readouterr().err


def test_a_cluster_whose_last_worker_dies_is_given_up_after_a_while(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    with cluster_of_one(tmp_path) as (address, worker):
        append = ResultFile.append

        def append_and_kill(file: ResultFile, key: str, record: Record) -> None:
            append(file, key, record)
            shorten(monkeypatch)
            worker.kill()
            worker.wait()

        monkeypatch.setattr(ResultFile, "append", append_and_kill)
        assert batch(out, "--seeds", "60", "--scheduler", address) == 1

    captured = capsys.readouterr()
    assert "no worker for 0.2 s; start some" in captured.err.splitlines()[-1]
    assert 1 <= len(entries(out)) < 120
    assert parquet.read_table(out / RUNS).num_rows == len(entries(out))


def test_a_batch_waits_for_the_first_worker_of_its_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    polls = SimpleQueue[int]()
    threads = cluster.Cluster.threads.fget
    assert threads is not None

    def count(self: cluster.Cluster) -> int:
        polls.put(found := threads(self))
        return found

    monkeypatch.setattr(cluster.Cluster, "threads", property(count))
    monkeypatch.setattr(cluster, "POLL_S", 0.05)
    with dask("dask_scheduler", *PLACE, "--port", "0") as scheduler, ExitStack() as stack:
        address = told(scheduler, "Scheduler at:")

        def start_a_worker() -> None:
            assert [polls.get(timeout=DEADLINE_S) for _ in range(3)] == [0, 0, 0]
            stack.enter_context(dask("dask_worker", address, *PLACE, *worker_options(tmp_path / "dask")))

        starting = Thread(target=start_a_worker)
        starting.start()
        assert batch(tmp_path / "out", "--seeds", "1", "--scheduler", address) == 0
        starting.join()

    assert len(entries(tmp_path / "out")) == 2


def shorten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "GRACE_S", 0.2)
    monkeypatch.setattr(cluster, "POLL_S", 0.05)


@contextmanager
def cluster_of_one(scratch: Path) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Run a scheduler and a worker; yield the address of the one, and the process of the other."""
    with dask("dask_scheduler", *PLACE, "--port", "0") as scheduler:
        address = told(scheduler, "Scheduler at:")
        with dask("dask_worker", address, *PLACE, *worker_options(scratch / "dask")) as worker:
            told(worker, "Registered to:")
            yield address, worker


def worker_options(scratch: Path) -> tuple[str, ...]:
    return ("--no-nanny", "--nthreads", "1", "--local-directory", str(scratch))


@contextmanager
def dask(module: str, *options: str) -> Iterator[subprocess.Popen[str]]:
    """Run a part of a Dask cluster that can import this project."""
    path = os.pathsep.join([str(ROOT / "scripts"), os.environ.get("PYTHONPATH", "")])
    command = [sys.executable, "-m", f"distributed.cli.{module}", *options]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONPATH": path}
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def told(process: subprocess.Popen[str], what: str) -> str:
    """Return the address that a part of a cluster tells after `what`."""
    assert process.stderr is not None
    line = next(line for line in process.stderr if what in line)
    return line.rpartition(what)[2].strip()
