"""What an assembly run is: map, docks, events, settings and seed, as one strict configuration."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from bringup.family import Family
from bringup.scenario import Stoppable, check_name
from mission_computer.assembly.desk import DeskConfig
from swarm_agent.assembly.steering import SkipperConfig
from swarm_msgs_py.assembly.faces import Face, Gender
from swarm_msgs_py.config import Config, section, setting
from swarm_msgs_py.errors import ConfigError
from swarm_msgs_py.types import MISSION, NodeId
from swarm_sim.boats.simulation import BoatSimConfig

FACES = {face.name.lower(): face for face in Face}


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec(Config):
    """What is to be built, by which boats, from where."""

    name: str | None = setting(None, "map of the library, e.g. map_1 or boats_5_square")
    file: str | None = setting(None, "JSON file, relative to the scenario's own folder")
    docks: Gender = setting(Gender.GENDERLESS, "genderless: any two mechanisms join; gendered: type 1 joins type 2")
    random_turns: bool = setting(False, "each boat starts at a random quarter turn (experiments of the paper)")

    def __post_init__(self) -> None:
        """Check that there is exactly one source."""
        Config.__post_init__(self)
        if (self.name is None) == (self.file is None):
            raise ConfigError("give either the name of a map or a file")


class Navigation(Enum):
    """Who finds the ways of the boats."""

    TIMED = "timed"
    """The mission computer, step by step."""
    DECENTRALIZED = "decentralized"
    """Every boat by itself, from guidepost to guidepost, after a tabu search (the published method)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MagnetSpec(Config):
    """One side of one boat."""

    boat: int = setting(help="boat, from 0", minimum=0)
    side: str = setting(help="up, down, left or right, as the boat looks at its start")

    def __post_init__(self) -> None:
        """Check the side."""
        Config.__post_init__(self)
        if self.side not in FACES:
            raise ConfigError(f"side is '{self.side}'; give one of {', '.join(FACES)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class AssemblyEventSpec(Config):
    """Something that befalls the boats during a run."""

    at_s: float = setting(help="when: from the first tick that begins then or later", unit="s", minimum=0.0)
    kill: tuple[int, ...] = setting((), "boats whose computers die; hull, magnets and firmware stay", minimum=0)
    magnets: tuple[MagnetSpec, ...] = setting((), "magnets that fail, e.g. [{boat: 2, side: up}]")
    stop: Stoppable | None = setting(None, "mission_computer: its radio falls silent")

    def __post_init__(self) -> None:
        """Check that something happens."""
        Config.__post_init__(self)
        if not (self.kill or self.magnets or self.stop):
            raise ConfigError("an event without effect; give kill: [boats], magnets: [...] or stop: mission_computer")

    @property
    def dead(self) -> tuple[NodeId, ...]:
        """Whose electronics it ends."""
        boats = tuple(map(NodeId, self.kill))
        return boats if self.stop is None else (*boats, MISSION)


@dataclass(frozen=True, slots=True, kw_only=True)
class AssemblyScenario(Config):
    """One run, completely."""

    name: str = setting(help="name of the scenario; also part of the run folder's name")
    family: Family = setting(Family.ASSEMBLY, "family of behavior")
    description: str = setting("", "one line for people")
    seed: int = setting(1, "seed of everything that is drawn", minimum=0, maximum=2**32 - 1)
    duration_s: float = setting(600.0, "simulated time after which the mission counts as failed", unit="s", above=0.0)
    map: MapSpec = setting(help="what is to be built")
    navigation: Navigation = setting(
        Navigation.TIMED, "timed: the mission computer plans all ways; decentralized: boats find them (paper)"
    )
    boats: int = setting(0, "number of boats of the map, written down when a run is resolved", minimum=0)
    events: tuple[AssemblyEventSpec, ...] = setting((), "what befalls the boats, e.g. [{at_s: 5.0, kill: [3]}]")
    sim: BoatSimConfig = section(BoatSimConfig, "the world")
    agent: SkipperConfig = section(SkipperConfig, "every boat's software")
    mission: DeskConfig = section(DeskConfig, "the mission computer")

    def __post_init__(self) -> None:
        """Check that the name can be a part of a folder's name."""
        Config.__post_init__(self)
        check_name(self.name)

    @property
    def robot_count(self) -> int:
        """Number of boats."""
        return self.boats

    @property
    def period_s(self) -> float:
        """Duration of a tick [s]."""
        return self.sim.period_s
