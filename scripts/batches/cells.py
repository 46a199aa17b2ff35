"""What a batch runs: the cross product of scenarios, shapes, methods and objectives, each with the same seeds."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

from batches.turns import turned
from bringup.family import Family
from bringup.resolution import written_out
from bringup.scenario import Scenario
from bringup.scenario_file import (
    Origin,
    Override,
    dump_scenario,
    load_any,
    load_scenario,
    method_overrides,
    shape_override,
)
from swarm_msgs_py.errors import ConfigError

STUDIES = {
    Family.COVERAGE: "scripts/coverage_study.py",
    Family.ASSEMBLY: "benchmarks/assembly_maps.py and benchmarks/assembly_pool.py",
}
"""What compares the other families over many seeds."""

OBJECTIVE, BACKEND = "agent.decision.objective", "sim.physics.backend"
BLOCK = 10
"""Seeds of a cell that are run before the next cell's turn: a worker keeps what it has computed of a shape, and a batch
that is stopped has about as many seeds of every cell."""

FINGERPRINT_DIGITS = 8
TURNED = "-turned"
"""What the fingerprint of a cell ends with whose shape has another orientation for every seed."""
SEED = ", seed "


@dataclass(frozen=True, slots=True, kw_only=True)
class Design:
    """What the operator wants to have compared; an empty tuple leaves to the scenario what it says.

    Attributes
    ----------
    scenarios, shapes, methods, objectives : tuple of str
        As the command line names them.
    overrides : tuple of Override
        Of all runs.
    is_turned : bool
        Whether the shape has another orientation for every seed.
    seeds : range
    """

    scenarios: tuple[str, ...]
    shapes: tuple[str, ...] = ()
    methods: tuple[str, ...] = ()
    objectives: tuple[str, ...] = ()
    overrides: tuple[Override, ...] = ()
    is_turned: bool = False
    seeds: range = range(1, 2)


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """One combination: all that a run is but for its seed.

    Attributes
    ----------
    scenario : Scenario
        Shape and map written out, so that a run needs no file; its seed does not count.
    origin : Origin
        Who said what, for errors.
    is_objective_named : bool
        Whether objectives are compared, and so belong to the name of the variant.
    fingerprint : str
        Tells apart scenarios that differ in anything but the seed; ends with `TURNED` if the seed turns the shape.
    """

    scenario: Scenario
    origin: Origin
    is_objective_named: bool
    fingerprint: str

    @property
    def place(self) -> tuple[str, str]:
        """Scenario and shape: cells that differ in nothing else than these cannot be compared."""
        return self.scenario.name, self.scenario.shape.name or ""

    @property
    def name(self) -> tuple[str, str, str, str]:
        """What people know this cell by; two that are compared must differ in it."""
        return (*self.place, self.method, self.objective)

    @property
    def is_turned(self) -> bool:
        """Whether the shape has another orientation for every seed."""
        return self.fingerprint.endswith(TURNED)

    @property
    def method(self) -> str:
        """Method of the mission."""
        return self.scenario.method

    @property
    def objective(self) -> str:
        """What the assignment of goals makes small."""
        return self.scenario.agent.decision.objective.value

    @property
    def variant(self) -> str:
        """What is compared at a place: the method, with its objective where several are compared."""
        return f"{self.method}, {self.objective}" if self.is_objective_named else self.method

    @property
    def key(self) -> str:
        """What tells this cell from others, for people and for the file of results."""
        return ", ".join((*self.name, self.fingerprint))


@dataclass(frozen=True, slots=True)
class Run:
    """One mission of a cell."""

    cell: Cell
    seed: int

    @property
    def key(self) -> str:
        """What tells this run from others in the file of results."""
        return f"{self.cell.key}{SEED}{self.seed}"

    @property
    def scenario(self) -> Scenario:
        """What is run."""
        scenario = replace(self.cell.scenario, seed=self.seed)
        return turned(scenario) if self.cell.is_turned else scenario


def seeds_by_cell(keys: Iterable[str]) -> dict[str, list[int]]:
    """Return the seeds of each cell among keys of runs, ascending; cells by key, in the order of their first run."""
    found: dict[str, list[int]] = {}
    for key in keys:
        cell, _, seed = key.rpartition(SEED)
        if cell and seed.isdecimal():
            found.setdefault(cell, []).append(int(seed))
    return {cell: sorted(seeds) for cell, seeds in found.items()}


def cells(design: Design) -> tuple[Cell, ...]:
    """Return all combinations: scenarios, then shapes, then methods, then objectives, in the order given.

    Raises
    ------
    ConfigError
        If one cannot be, or two could not be told apart by name.
    """
    for source in design.scenarios:
        _check_family(source)
    found: dict[tuple[str, ...], Cell] = {}
    choices = product(*map(_choices, (design.shapes, design.methods, design.objectives)))
    for source, (shape, method, objective) in product(design.scenarios, choices):
        cell = _cell(design, source, shape, method, objective)
        known = found.setdefault(cell.name, cell)
        if known.fingerprint != cell.fingerprint:
            raise ConfigError(
                f"two combinations would both be called '{', '.join((*cell.place, cell.method))}'; give scenario files "
                "different names (key 'name'), and shape files different file names"
            )
    return named_apart(found.values())


def named_apart(cells_: Iterable[Cell]) -> tuple[Cell, ...]:
    """Return cells whose variants have the objective in their name where several are compared."""
    every = tuple(cells_)
    several = len({cell.objective for cell in every}) > 1
    return tuple(replace(cell, is_objective_named=several) for cell in every)


def _choices(names: Sequence[str]) -> Sequence[str | None]:
    """Return what to choose from; None is what the scenario says."""
    return names or (None,)


def _check_family(source: str) -> None:
    """Refuse scenarios that batches cannot compare; before anything else is said of them.

    Raises
    ------
    ConfigError
        Naming what compares them.
    """
    scenario, _ = load_any(source, ())
    if scenario.family is not Family.FORMATION:
        study = STUDIES[scenario.family]
        raise ConfigError(f"--scenario {source}: batches compare formations; for {scenario.family.value} use {study}")


def _cell(design: Design, source: str, shape: str | None, method: str | None, objective: str | None) -> Cell:
    overrides: list[Override] = []
    if shape is not None:
        overrides.append(shape_override(shape))
    if method is not None:
        overrides += method_overrides(method)
    if objective is not None:
        overrides.append(Override(f"--objective {objective}", OBJECTIVE, objective))
    scenario, origin = load_scenario(source, (*overrides, *design.overrides))
    scenario = written_out(scenario, origin)
    text = dump_scenario(replace(scenario, seed=0))
    fingerprint = hashlib.sha256(text.encode()).hexdigest()[:FINGERPRINT_DIGITS]
    if design.is_turned and scenario.stages:
        raise ConfigError(f"--turns: {scenario.name} has several shapes, which one turn does not fit; leave it out")
    return Cell(scenario, origin, False, fingerprint + (TURNED if design.is_turned else ""))


def runs(cells_: Sequence[Cell], seeds: range) -> Iterator[Run]:
    """Yield every run of every cell once, in blocks of `BLOCK` seeds."""
    for first in range(0, len(seeds), BLOCK):
        for cell in cells_:
            for seed in seeds[first : first + BLOCK]:
                yield Run(cell, seed)
