from __future__ import annotations

import io
from dataclasses import replace

from rich.console import Console
from tick_builders import make_plan, make_tick

from bringup.progress import Progress

POINTS = [[0.0, 0.0], [2.0, 0.0]]


def plain_console() -> tuple[Console, io.StringIO]:
    text = io.StringIO()
    return Console(file=text, width=200), text


def test_a_plain_line_tells_time_and_robots() -> None:
    console, text = plain_console()
    with Progress(console) as progress:
        progress.show(make_tick(0, POINTS, plan=make_plan(POINTS)), 0.5, "2 of 2 robots at their goals")

    assert "0.5 s" in text.getvalue()
    assert "2 of 2 robots at their goals" in text.getvalue()


def test_an_alert_that_repeats_is_printed_once() -> None:
    console, text = plain_console()
    record = replace(make_tick(0, POINTS), alerts=("r01 died: [exit code 9]",))
    with Progress(console) as progress:
        progress.show(record, 0.5, "")
        progress.show(record, 1.0, "")

    assert text.getvalue().count("r01 died: [exit code 9]") == 1


def test_a_terminal_gets_one_live_line_that_goes_away() -> None:
    text = io.StringIO()
    with Progress(Console(file=text, width=120, force_terminal=True)) as progress:
        progress.show(make_tick(0, POINTS), 0.5, "1 of 2 robots")

    assert "1 of 2 robots" in text.getvalue()
    assert text.getvalue().endswith("\x1b[2K") or "\x1b[?25h" in text.getvalue()
