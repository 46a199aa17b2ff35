"""Sums over a run that need no time axis: contacts, clearance, radio traffic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from swarm_sim.metrics.contacts import count_contacts
from swarm_sim.simulation import TickTruth


@dataclass(frozen=True, slots=True)
class RunTotals:
    """What all ticks of a run add up to.

    Attributes
    ----------
    contacts : int
        Episodes in which two coverage circles, or a circle and an obstacle, overlapped.
    min_clearance : float or None
        Smallest free gap, negative in an overlap; None where there was nothing to collide with [m].
    radio_frames, radio_bytes : int
        Transmitted by all radios.
    radio_dropped : int
        Frames that exceeded a radio's budget.
    radio_peak_bps : float
        Largest rate of any one radio in any tick [bit/s].
    radio_neighborhood_peak_bps : float
        Largest rate of any one radio and all that it hears together, over any second [bit/s].
    """

    contacts: int
    min_clearance: float | None
    radio_frames: int
    radio_bytes: int
    radio_dropped: int
    radio_peak_bps: float
    radio_neighborhood_peak_bps: float


def run_totals(truths: Sequence[TickTruth]) -> RunTotals:
    """Return the totals of the ticks of one run, in order."""
    clearance = min((truth.min_clearance for truth in truths), default=math.inf)
    return RunTotals(
        contacts=count_contacts(truth.overlaps for truth in truths),
        min_clearance=clearance if math.isfinite(clearance) else None,
        radio_frames=sum(truth.radio.frames for truth in truths),
        radio_bytes=sum(truth.radio.bytes for truth in truths),
        radio_dropped=sum(truth.radio.dropped for truth in truths),
        radio_peak_bps=max((truth.radio.peak_bps for truth in truths), default=0.0),
        radio_neighborhood_peak_bps=max((truth.radio.neighborhood_bps for truth in truths), default=0.0),
    )
