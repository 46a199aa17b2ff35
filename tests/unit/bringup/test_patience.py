"""Patience counts time spent waiting in vain, and starts anew with every piece of news."""

from __future__ import annotations

from bringup.patience import Patience


def test_it_runs_out_after_waiting_long_enough_in_vain_and_then_begins_anew() -> None:
    patience = Patience(2.0)

    assert [patience.is_out(0.5, has_news=False) for _ in range(8)] == [False, False, False, True] * 2


def test_news_restores_it() -> None:
    patience = Patience(1.0)

    assert [patience.is_out(0.5, has_news=news) for news in (False, True, False, True, False, False)] == [
        *[False] * 5,
        True,
    ]
