"""How a run ended."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a run ended.

    Attributes
    ----------
    achieved : bool
    reason : str
        One line for the operator.
    """

    achieved: bool
    reason: str


@dataclass(frozen=True, slots=True)
class Timing:
    """How a run went by the wall clock.

    Attributes
    ----------
    startup_s : float
        From the start of the engine to the first tick [s].
    wall_time_s : float
        From the first tick to the last [s].
    """

    startup_s: float
    wall_time_s: float
