"""How scenarios of each family are run."""

from __future__ import annotations

from types import MappingProxyType

from bringup.assembly.behavior import AssemblyBehavior
from bringup.coverage.behavior import CoverageBehavior
from bringup.family import Behavior, Family
from bringup.formation import FormationBehavior

BEHAVIORS: MappingProxyType[Family, Behavior] = MappingProxyType(
    {Family.FORMATION: FormationBehavior(), Family.COVERAGE: CoverageBehavior(), Family.ASSEMBLY: AssemblyBehavior()}
)
"""One of each family."""
