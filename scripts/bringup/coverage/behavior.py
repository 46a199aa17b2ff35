"""How coverage scenarios are run."""

from __future__ import annotations

from bringup.coverage.account import CoverageAccount
from bringup.coverage.actors import CoverageActors
from bringup.coverage.resolution import resolve
from bringup.coverage.scenario import CoverageScenario
from bringup.coverage.scenes import CoverageScenes
from bringup.origin import Origin


class CoverageBehavior:
    """Implements `bringup.family.Behavior`."""

    def check_installation(self, scenario: CoverageScenario) -> None:
        """Do nothing: what it needs is needed by all."""

    def resolve(self, scenario: CoverageScenario, origin: Origin) -> CoverageScenario:
        """Return the scenario with its shapes written out."""
        return resolve(scenario, origin)

    def actors(self, scenario: CoverageScenario) -> CoverageActors:
        """Return what makes the actors of a resolved scenario."""
        return CoverageActors(scenario)

    def scenes(self, scenario: CoverageScenario) -> CoverageScenes:
        """Return what turns the ticks of a resolved scenario into what onlookers see."""
        return CoverageScenes(scenario)

    def account(self, scenario: CoverageScenario) -> CoverageAccount:
        """Return the account of a run of a resolved scenario that is about to begin."""
        return CoverageAccount(scenario)
