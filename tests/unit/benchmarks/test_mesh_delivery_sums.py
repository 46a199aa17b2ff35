"""What the benchmark of the mesh counts, and how it judges routes."""

from __future__ import annotations

import pytest
from mesh_delivery import _route_stretch, _Sent, _sums


def make_sent(needed: int, route: int | None, arrived: int | None = 5) -> _Sent:
    return _Sent(tick=0, ends=(0, 1), needed=needed, route=route, path=needed, arrived=arrived)


def test_a_claim_shorter_than_any_path_makes_up_for_no_detour() -> None:
    outcome = _sums([make_sent(needed=4, route=2), make_sent(needed=4, route=6)])

    assert _route_stretch([outcome]) == pytest.approx(10 / 8)


def test_a_packet_without_a_route_is_counted_and_judged_by_its_delivery_only() -> None:
    outcome = _sums([make_sent(needed=4, route=None, arrived=None), make_sent(needed=4, route=4)])

    assert (outcome.counted, outcome.delivered, outcome.no_route) == (2, 1, 1)
    assert _route_stretch([outcome]) == 1.0
