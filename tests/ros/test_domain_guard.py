"""One swarm per ROS domain: refused with the way out, free again as soon as its holder is gone, no file anywhere."""

from __future__ import annotations

import os
import signal
import tempfile
from pathlib import Path

import pytest

from bringup.domain_guard import LAST_SAFE_DOMAIN, DomainGuard, domain_of
from swarm_msgs_py.errors import ConfigError


def test_a_taken_domain_is_refused_in_a_line_that_names_the_holder_and_the_way_out(domain_id: int) -> None:
    first, second = DomainGuard(domain_id), DomainGuard(domain_id)
    first.acquire()

    for _ in range(100):  # nobody takes these calls, and still the answer stays a refusal
        with pytest.raises(ConfigError, match=rf"^ROS_DOMAIN_ID: domain {domain_id} is in use by .*swarm.*; set "):
            second.acquire()
    with pytest.raises(ConfigError, match=r"to another number \(0 to 101\)"):
        second.acquire()

    first.release()
    second.acquire()
    second.release()
    second.release()


def test_the_holder_is_named_by_its_process(domain_id: int) -> None:
    guard = DomainGuard(domain_id)
    guard.acquire()

    with pytest.raises(ConfigError, match=f"by the swarm of process {os.getpid()};"):
        DomainGuard(domain_id).acquire()
    guard.release()


def test_a_holder_that_is_killed_leaves_no_claim_and_no_file(
    domain_id: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    reading, writing = os.pipe()
    holder = os.fork()
    if holder == 0:
        try:
            held = DomainGuard(domain_id)
            held.acquire()
            os.write(writing, b"held")
            signal.pause()
        finally:
            os._exit(1)
    os.close(writing)  # so that reading ends if the holder does
    try:
        assert os.read(reading, 4) == b"held"
        with pytest.raises(ConfigError, match=f"by the swarm of process {holder};"):
            DomainGuard(domain_id).acquire()
    finally:
        os.kill(holder, signal.SIGKILL)
        os.waitpid(holder, 0)

    guard = DomainGuard(domain_id)
    guard.acquire()
    guard.release()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("text", "domain"), [(None, 0), ("", 0), ("7", 7), ("232", 232)])
def test_the_environment_chooses_the_domain(text: str | None, domain: int) -> None:
    assert domain_of({} if text is None else {"ROS_DOMAIN_ID": text}) == domain


def test_the_suggested_domain_is_one_that_exists() -> None:
    guard = DomainGuard(LAST_SAFE_DOMAIN)
    guard.acquire()

    with pytest.raises(ConfigError, match=r"e\.g\. ROS_DOMAIN_ID=0$"):
        DomainGuard(LAST_SAFE_DOMAIN).acquire()
    guard.release()
