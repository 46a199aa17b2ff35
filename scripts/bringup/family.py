"""The seam between the launcher and a family of behavior: what a family brings, and what is the same for all.

The launcher, the engines, the run folder and the progress line know families only by these protocols. A family is a
`Kind` (its scenario files and options), `Actors` (`bringup.engine`) and an `Account` of the run; `bringup.families`
lists those that there are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any, Protocol

import numpy as np

from bringup.engine import Actors, TickRecord
from bringup.origin import Origin, Override
from bringup.scene import Scenes
from bringup.verdict import Timing, Verdict
from swarm_msgs_py.config import Config


class Family(Enum):
    """Families of behavior."""

    FORMATION = "formation"
    COVERAGE = "coverage"
    ASSEMBLY = "assembly"


class AnyScenario(Protocol):
    """One run of any family, completely; a `Config`."""

    @property
    def name(self) -> str:
        """Name of the scenario; also part of the run folder's name."""
        ...

    @property
    def description(self) -> str:
        """What it shows, in a line."""
        ...

    @property
    def family(self) -> Family:
        """Family of behavior."""
        ...

    @property
    def seed(self) -> int:
        """Seed of everything that is drawn."""
        ...

    @property
    def robot_count(self) -> int:
        """Number of robots."""
        ...

    @property
    def period_s(self) -> float:
        """Duration of a tick [s]."""
        ...


@dataclass(frozen=True, slots=True)
class Metrics:
    """The numbers of a run, as ``metrics.json`` holds them; each family adds its own.

    Attributes
    ----------
    values : mapping
        By key, in the order of the file; None is a number that does not apply.
    rows : tuple of (str, str)
        What the operator reads of them at the end: label and text.
    """

    values: Mapping[str, Any]
    rows: tuple[tuple[str, str], ...]

    @property
    def achieved(self) -> bool:
        """Whether the mission was achieved."""
        return bool(self.values["achieved"])

    @property
    def reason(self) -> str:
        """Why, in a line."""
        return str(self.values["reason"])


class Account(Protocol):
    """What is noted of one run, from true states and reports; the robots never hear of it."""

    def take(self, record: TickRecord[Any, Any]) -> Verdict | None:
        """Take in one tick; return the verdict when there is one."""
        ...

    @property
    def ticks(self) -> int:
        """How many ticks were taken."""
        ...

    @property
    def alerts(self) -> tuple[str, ...]:
        """What the account itself has to say of the last tick, beside what the record says."""
        ...

    @property
    def status(self) -> str:
        """How far the swarm is, for the live line."""
        ...

    def interrupted(self, time: float) -> Verdict:
        """Return the verdict of a run that the operator ended at `time` [s]."""
        ...

    def unfinished(self, time: float) -> Verdict:
        """Return the verdict that is on disk while the run goes on, at `time` [s]."""
        ...

    def metrics(self, engine: str, verdict: Verdict, timing: Timing) -> Metrics:
        """Evaluate the run, finished or not."""
        ...

    def arrays(self) -> Mapping[str, np.ndarray]:
        """Return what ``trajectories.npz`` holds, by name; SI units (`reports.run_record` says what it must)."""
        ...

    def figure(self, metrics: Metrics) -> bytes:
        """Return the picture of the run as PNG."""
        ...


class Kind(Protocol):
    """How one family's scenarios are written: files and options of the command line."""

    @property
    def family(self) -> Family:
        """Which family."""
        ...

    @property
    def scenario(self) -> type[Config]:
        """Class of its scenarios."""
        ...

    @property
    def methods(self) -> tuple[str, ...]:
        """What ``--method`` takes."""
        ...

    def completed(self, data: dict[str, Any]) -> dict[str, Any]:
        """Return plain data with what may be left out filled in; the strict loader refuses what is malformed."""
        ...

    def located(self, data: dict[str, Any], folder: str) -> None:
        """Make file names in plain data relative to the present folder, in place."""
        ...

    def with_count(self, data: dict[str, Any], count: int) -> None:
        """Set the number of robots in plain data that were loaded once, in place."""
        ...

    def shape_override(self, source: str) -> Override:
        """Return the override of ``--shape``."""
        ...

    def map_override(self, source: str) -> Override:
        """Return the override of ``--map``."""
        ...

    def method_overrides(self, name: str) -> tuple[Override, ...]:
        """Return the overrides of ``--method``."""
        ...

    def physics_override(self, backend: str) -> Override:
        """Return the override of ``--physics``."""
        ...


class Behavior(Protocol):
    """How one family's scenarios are run."""

    def check_installation(self, scenario: Any) -> None:
        """Refuse what needs a library that is not there."""
        ...

    def resolve(self, scenario: Any, origin: Origin) -> Any:
        """Return the scenario with everything written out, after every check that needs no run."""
        ...

    def actors(self, scenario: Any) -> Actors:
        """Return what makes the actors of a resolved scenario."""
        ...

    def scenes(self, scenario: Any) -> Scenes:
        """Return what turns the ticks of a resolved scenario into what onlookers see."""
        ...

    def account(self, scenario: Any) -> Account:
        """Return the account of a run of a resolved scenario that is about to begin."""
        ...
