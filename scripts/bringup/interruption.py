"""Ctrl-C and termination as one exception, raised only where the program can take it."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Interruption:
    """Turns the first SIGINT, SIGTERM or SIGHUP into one `KeyboardInterrupt`.

    Use as a context manager in the main thread.

    Outside `welcome` a signal is only noted, so that stopping and writing are never torn apart; a second signal adds
    nothing. Where SIGHUP is ignored, as under ``nohup``, it stays so.

    Attributes
    ----------
    requested : bool
        Whether the operator wants an end.
    """

    def __init__(self) -> None:
        self.requested = False
        self._is_welcome = False
        self._previous: dict[signal.Signals, object] = {}

    def __enter__(self) -> Interruption:
        """Take over the signals."""
        is_detached = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        heard = (number for number in SIGNALS if not (is_detached and number is signal.SIGHUP))
        self._previous = {number: signal.signal(number, self._note) for number in heard}
        return self

    def __exit__(self, *error: object) -> None:
        """Give the signals back."""
        for number, handler in self._previous.items():
            signal.signal(number, handler)  # type: ignore[arg-type]  # what signal.signal returned

    @contextmanager
    def welcome(self) -> Iterator[None]:
        """Let an interruption, also one noted before, end this block by `KeyboardInterrupt`."""
        self._is_welcome = True
        try:
            self.check()
            yield
        finally:
            self._is_welcome = False

    def check(self) -> None:
        """Raise `KeyboardInterrupt` if an interruption was noted."""
        if self.requested:
            raise KeyboardInterrupt

    def _note(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002 - the shape of a signal handler
        is_first, self.requested = not self.requested, True
        if is_first and self._is_welcome:
            raise KeyboardInterrupt
