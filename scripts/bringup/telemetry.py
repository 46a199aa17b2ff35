"""What the processes of a ROS run tell the orchestrator, and what it tells them.

Telemetry leaves the swarm and never enters it: robots decide nothing from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from recording.taking import Account
from swarm_msgs_py.messages.bodies import Plan
from swarm_msgs_py.messages.report import MissionReport
from swarm_msgs_py.types import NodeId
from swarm_sim.ticked_world import Truth

REASON_MAX = 300  # characters of an exception that an alert repeats


def reason_of(error: BaseException) -> str:
    """Return what went wrong, in a line of bearable length."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return text if len(text) <= REASON_MAX else text[: REASON_MAX - 3] + "..."


@dataclass(frozen=True, slots=True)
class Ready:
    """From any child: its nodes are up and everybody they need is connected."""


@dataclass(frozen=True, slots=True)
class Failed:
    """From any child, before it ends: why."""

    reason: str

    @classmethod
    def of(cls, error: BaseException) -> Failed:
        """Return the record of an exception, in a line."""
        return cls(reason_of(error))


@dataclass(frozen=True, slots=True)
class AgentFailed:
    """From a process of agents: one of its robots has failed and is taken out; the others go on."""

    robot: NodeId
    reason: str


@dataclass(frozen=True, slots=True)
class Alive:
    """From the world, about every second: it is not stuck, even if no tick runs because it is paused or waits."""


@dataclass(frozen=True, slots=True, eq=False)
class WorldTick:
    """From the world: a tick has run.

    Attributes
    ----------
    truth : Truth
    answered : frozenset of NodeId
        Who answered in time; their reports are on the way.
    alerts : tuple of str
    lost : frozenset of NodeId
    """

    truth: Truth
    answered: frozenset[NodeId]
    alerts: tuple[str, ...]
    lost: frozenset[NodeId]


@dataclass(frozen=True, slots=True, eq=False)
class AgentReports:
    """From a process of agents: what its robots said of themselves in a tick."""

    tick: int
    reports: Mapping[NodeId, Any]


@dataclass(frozen=True, slots=True, eq=False)
class MissionTick:
    """From the mission computer: its report of a tick, and the plan if it changed."""

    tick: int
    report: MissionReport
    plan: Plan | None


@dataclass(frozen=True, slots=True)
class Recorded:
    """From the recorder: what the swarm says in this tick is being written."""

    tick: int


@dataclass(frozen=True, slots=True, eq=False)
class RecordingClosed:
    """From the recorder, before it ends: what the recording holds."""

    account: Account


@dataclass(frozen=True, slots=True)
class Hosts:
    """To the world, before the first tick: in which process each node is."""

    pids: Mapping[NodeId, int]


@dataclass(frozen=True, slots=True)
class RunUntil:
    """To the world: ticks below `tick` may begin. Keeps it from running away from a slow reader of the records."""

    tick: int


@dataclass(frozen=True, slots=True)
class Fallen:
    """To the world: the processes of these nodes have died."""

    nodes: tuple[NodeId, ...]


@dataclass(frozen=True, slots=True)
class Stop:
    """To any child: end."""
