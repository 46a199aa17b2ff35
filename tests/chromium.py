"""A real Chromium for tests of pages, driven by Playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
"""What distributions and Google call it."""

FETCHED = ("chrome-headless-shell", "headless_shell", "chrome")
"""What ``playwright install`` calls it."""


@cache
def executable() -> str | None:
    """Return the Chromium to use: that of ``CHROMIUM``, of the system, or that Playwright has fetched; None without."""
    wanted = os.environ.get("CHROMIUM")
    found = wanted or next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is not None:
        return found
    own = Path(os.environ.get("PLAYWRIGHT_BROWSERS_PATH", Path.home() / ".cache" / "ms-playwright"))
    fetched = sorted(path for name in FETCHED for path in own.glob(f"chromium*/*/{name}"))
    return str(fetched[-1]) if fetched else None


@contextmanager
def browser() -> Iterator[Browser]:
    """Start a headless Chromium.

    Raises
    ------
    RuntimeError
        If there is none.
    """
    path = executable()
    if path is None:
        raise RuntimeError("no Chromium: install your distribution's package, or name one in CHROMIUM")
    with sync_playwright() as playwright:
        # The sandbox needs rights that containers withhold; nothing but our own page is loaded.
        found = playwright.chromium.launch(executable_path=path, args=["--no-sandbox", "--disable-gpu"])
        try:
            yield found
        finally:
            found.close()
