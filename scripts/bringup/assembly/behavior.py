"""How assembly scenarios are run."""

from __future__ import annotations

from dataclasses import replace

from bringup.assembly.account import AssemblyAccount
from bringup.assembly.actors import AssemblyActors
from bringup.assembly.planning import planned
from bringup.assembly.scenario import AssemblyScenario
from bringup.assembly.scenes import AssemblyScenes
from bringup.origin import Origin, blamed
from swarm_msgs_py.errors import AssemblyError, ConfigError
from swarm_msgs_py.types import NodeId, robot_name


class AssemblyBehavior:
    """Implements `bringup.family.Behavior`."""

    def check_installation(self, scenario: AssemblyScenario) -> None:
        """Do nothing: what it needs is needed by all, and the world says what it lacks."""

    def resolve(self, scenario: AssemblyScenario, origin: Origin) -> AssemblyScenario:
        """Return the scenario with its number of boats; refuse a map from which nothing can be built.

        Raises
        ------
        ConfigError
            One line that names the file or option, the key and the remedy.
        """
        try:
            boats = planned(scenario).problem.boat_count
        except AssemblyError as error:
            raise ConfigError(f"{origin.of('map')}: {error}") from None
        for number, event in enumerate(scenario.events):
            with blamed(origin, f"events[{number}]"):
                for boat in (*event.kill, *(magnet.boat for magnet in event.magnets)):
                    if boat >= boats:
                        raise ConfigError(f"there is no {robot_name(NodeId(boat))}; the map has {boats} boats")
        return replace(scenario, boats=boats)

    def actors(self, scenario: AssemblyScenario) -> AssemblyActors:
        """Return what makes the actors of a resolved scenario."""
        return AssemblyActors(scenario)

    def scenes(self, scenario: AssemblyScenario) -> AssemblyScenes:
        """Return what turns the ticks of a resolved scenario into what onlookers see."""
        return AssemblyScenes(scenario)

    def account(self, scenario: AssemblyScenario) -> AssemblyAccount:
        """Return the account of a run of a resolved scenario that is about to begin."""
        return AssemblyAccount(scenario)
