from __future__ import annotations

import io
import os

from rich.console import Console

from bringup.steady_stream import steady


def test_a_pipe_without_reader_silences_the_stream_and_raises_nothing() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w", encoding="utf-8") as pipe:
        stream = steady(pipe)
        console = Console(file=stream)
        console.print("nobody hears this")
        console.print("nor this")
        stream.flush()

        assert not stream.isatty()
        # Python flushes what is left at its end; that must not fail, either.
        pipe.write("late")
        pipe.flush()


def test_a_stream_with_a_reader_gets_everything() -> None:
    text = io.StringIO()
    stream = steady(text)
    stream.write("one ")
    stream.flush()
    stream.write("two")

    assert text.getvalue() == "one two"


def test_a_letter_that_the_terminal_does_not_have_is_written_otherwise() -> None:
    taken = io.BytesIO()
    stream = steady(io.TextIOWrapper(taken, encoding="ascii"))

    stream.write("d\u00e4mo")
    stream.flush()

    assert taken.getvalue() == b"d\\xe4mo"
