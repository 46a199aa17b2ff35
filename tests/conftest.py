"""What all tests share: the order of the folders, the Hypothesis profile, and what happens where ROS is absent."""

from __future__ import annotations

import importlib.util
import socket
from collections.abc import Iterator
from pathlib import Path

import chromium
import pytest
from hypothesis import settings

TESTS = Path(__file__).parent
ORDER = ("unit", "property", "contract", "scenario", "golden", "ros", "system")
"""Fast and local first, so that a broken rule is not reported as a broken swarm minutes later."""

HAS_ROS = importlib.util.find_spec("rclpy") is not None
LAST_SAFE_DOMAIN = 101  # above it, the UDP ports of a domain reach into Linux's ephemeral range

collect_ignore = [] if HAS_ROS else ["ros"]

# The same examples in every run: a red test stays red until it is mended, on every machine.
settings.register_profile("reproducible", derandomize=True, deadline=None, database=None, max_examples=50)
settings.load_profile("reproducible")


def pytest_configure(config: pytest.Config) -> None:
    """Declare the markers of tests that need what not every machine has."""
    config.addinivalue_line("markers", "needs_ros: starts ROS nodes; skipped where rclpy is not installed")
    config.addinivalue_line("markers", "needs_browser: opens pages in Chromium; skipped where there is none")


def pytest_report_header() -> list[str]:
    """Return the lines that say whether tests with ROS and with a browser take part."""
    ros = "found" if HAS_ROS else "rclpy is not installed; tests/ros is left out, needs_ros tests skip"
    browser = chromium.executable() or "none; needs_browser tests skip (install one, or name it in CHROMIUM)"
    return [f"ROS 2: {ros}", f"Chromium: {browser}"]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests by folder, and skip those that need what is not there."""
    items.sort(key=lambda item: _rank(item.path))
    if not HAS_ROS:
        _skip(items, "needs_ros", "rclpy is not installed")
    if chromium.executable() is None:
        _skip(items, "needs_browser", "there is no Chromium")


def _skip(items: list[pytest.Item], marker: str, reason: str) -> None:
    for item in items:
        if item.get_closest_marker(marker):
            item.add_marker(pytest.mark.skip(reason=reason))


def _rank(path: Path) -> int:
    folder = path.relative_to(TESTS).parts[0] if path.is_relative_to(TESTS) else ""
    return ORDER.index(folder) if folder in ORDER else -1


@pytest.fixture
def domain_id(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Reserve a ROS domain that no other test on this machine uses, and set it for child processes."""
    # A name in Linux's abstract socket space is a lock that the kernel drops with the process.
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as lock:
        domain = next(number for number in range(1, LAST_SAFE_DOMAIN + 1) if _reserve(lock, number))
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        yield domain


def _reserve(lock: socket.socket, domain: int) -> bool:
    try:
        lock.bind(f"\0swarm-test-domain-{domain}")
    except OSError:
        return False
    return True
