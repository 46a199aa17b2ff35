from __future__ import annotations

import base64

import numpy as np
import pytest
from recorded_runs import made_run

from reports.packing import packed, packed_whole
from reports.replay_data import replay_data

KINDS = {"i1": "<i1", "i2": "<i2", "i4": "<i4"}


def unpacked(data: dict[str, object]) -> np.ndarray:
    """Return what packed.js makes of it."""
    whole = np.frombuffer(base64.b64decode(str(data["data"])), dtype=KINDS[str(data["kind"])]).astype(float)
    values = np.where(whole == -32768, np.nan, float(data["middle"]) + whole * float(data["scale"]))  # type: ignore[arg-type]
    return values.reshape(data["shape"])


def test_numbers_survive_to_the_step_that_was_asked_for() -> None:
    values = np.array([[-12.345, 3.2], [np.nan, 100.0]])

    assert unpacked(packed(values, 0.01)) == pytest.approx(values, abs=0.005 + 1e-9, nan_ok=True)


def test_what_does_not_fit_into_two_bytes_gets_coarser_and_nothing_is_cut_off() -> None:
    values = np.array([-5000.0, 0.0, 5000.0])

    assert unpacked(packed(values, 0.01)) == pytest.approx(values, abs=5000.0 / 32767 / 2 + 1e-9)


def test_axes_of_small_ellipses_never_become_negative() -> None:
    covariance = np.zeros((21, 6, 2, 2)) + 1e-7 * np.eye(2)
    record = made_run(covariance=covariance[:20], coverage_radius=np.full(6, 0.08))

    data = replay_data(record)

    axes = unpacked(data["ellipse"])
    assert axes.min() >= 0.0
    assert axes == pytest.approx(2.0 * np.sqrt(1e-7), abs=5e-4)
    assert unpacked(data["ellipse_turn"]) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("values", [np.empty((0, 2)), np.full(3, np.nan), np.full(2, 7.5)])
def test_arrays_without_a_spread_can_be_packed(values: np.ndarray) -> None:
    assert unpacked(packed(values, 0.01)) == pytest.approx(values, nan_ok=True)


@pytest.mark.parametrize(("largest", "size"), [(127, 1), (128, 2), (40000, 4)])
def test_whole_numbers_take_as_few_bytes_as_they_need(largest: int, size: int) -> None:
    data = packed_whole(np.array([-largest, largest]))

    raw = base64.b64decode(data["data"])
    assert len(raw) == 2 * size
    assert np.frombuffer(raw, dtype=KINDS[data["kind"]]).tolist() == [-largest, largest]
