"""How scenarios of each family are written."""

from __future__ import annotations

from types import MappingProxyType

from bringup.assembly.kind import AssemblyKind
from bringup.coverage.kind import CoverageKind
from bringup.family import Kind
from bringup.formation_kind import FORMATION

_KINDS: tuple[Kind, ...] = (FORMATION, CoverageKind(), AssemblyKind())

KINDS = MappingProxyType({kind.family: kind for kind in _KINDS})
"""One of each family."""
