"""Output that nobody may read any more: a run must not end because its terminal or the next program in a pipe did."""

from __future__ import annotations

import io
import os
from typing import TextIO, cast


class SteadyStream(io.TextIOBase):
    """Text stream that falls silent, instead of raising, when it can no longer be written to.

    Parameters
    ----------
    stream : TextIO
        Where text goes as long as it can.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._is_mute = False

    @property
    def encoding(self) -> str:  # type: ignore[override]  # typeshed has it as a variable
        """Encoding of the stream, which decides which characters Rich draws with."""
        return self._stream.encoding or "utf-8"

    def write(self, text: str) -> int:
        """Write, or pretend to; return the number of characters taken."""
        try:
            if not self._is_mute:
                self._stream.write(text)
        except OSError:
            self._mute()
        return len(text)

    def flush(self) -> None:
        """Hand over what is buffered, if anybody takes it."""
        try:
            if not self._is_mute:
                self._stream.flush()
        except OSError:
            self._mute()

    def isatty(self) -> bool:
        """Return whether somebody watches live."""
        return not self._is_mute and self._stream.isatty()

    def fileno(self) -> int:
        """Return the descriptor of the stream."""
        return self._stream.fileno()

    def _mute(self) -> None:
        self._is_mute = True
        # What the stream still buffers is flushed when Python ends; it must not fail then, either.
        try:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)
        except OSError:  # a stream without descriptor, as tests use
            pass


def steady(stream: TextIO) -> TextIO:
    """Return `stream` as one that never raises for want of a reader, or of a letter in its encoding."""
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="backslashreplace")
    return cast(TextIO, SteadyStream(stream))
