"""What the runs of each cell come to, and how the methods at one place differ on equal starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from batches.cells import Cell, Run, seeds_by_cell
from batches.estimates import Estimate, estimate, paired_difference, share
from batches.quantities import QUANTITIES, SETTLING, SHARE, Quantity, value_of
from studies.campaign import Record

Place = tuple[str, str]
"""Scenario and shape."""

SETTLED = next(quantity for quantity in QUANTITIES if quantity.name == SETTLING)
"""What every run has that settled, and no other."""


class Comparison:
    """All cells of a batch, with the runs that have results.

    Parameters
    ----------
    cells : sequence of Cell
    records : mapping
        Results by key of run; those of other cells are left out.
    """

    def __init__(self, cells: Sequence[Cell], records: Mapping[str, Record]) -> None:
        self.cells = tuple(cells)
        # By seed, not as they finished: sums of floats depend on their order.
        seeds = seeds_by_cell(records)
        self._records: dict[str, dict[int, Record]] = {
            cell.key: {seed: records[Run(cell, seed).key] for seed in seeds.get(cell.key, ())} for cell in cells
        }

    @property
    def places(self) -> tuple[Place, ...]:
        """Scenarios and shapes that have results, in the order of the cells."""
        return tuple(dict.fromkeys(cell.place for cell in self.cells if self.count(cell)))

    @property
    def variants(self) -> tuple[str, ...]:
        """Names of what is compared, in the order of the cells."""
        return tuple(dict.fromkeys(cell.variant for cell in self.cells))

    @property
    def runs(self) -> tuple[Run, ...]:
        """All runs that have results, by cell and then by seed."""
        return tuple(Run(cell, seed) for cell in self.cells for seed in self._records[cell.key])

    def at(self, place: Place) -> tuple[Cell, ...]:
        """Return the cells of one place that have results."""
        return tuple(cell for cell in self.cells if cell.place == place and self.count(cell))

    def count(self, cell: Cell) -> int:
        """Return how many runs of a cell there are."""
        return len(self._records[cell.key])

    def settled(self, cell: Cell) -> str:
        """Return how many runs of a cell settled, of how many."""
        return f"{len(self.values(cell, SETTLED))}/{self.count(cell)}"

    def all_settled(self, cell: Cell) -> bool:
        """Return whether every run of a cell settled."""
        return len(self.values(cell, SETTLED)) == self.count(cell)

    def values(self, cell: Cell, quantity: Quantity) -> dict[int, float]:
        """Return one number of a cell by seed, of the runs that have it."""
        found = {seed: value_of(quantity, record) for seed, record in self._records[cell.key].items()}
        return {seed: value for seed, value in found.items() if value is not None}

    def estimate(self, cell: Cell, quantity: Quantity) -> Estimate | None:
        """Return mean or share of one number over the seeds of a cell; None where no run has it."""
        values = list(self.values(cell, quantity).values())
        if quantity is SHARE:
            return share([value > 0.0 for value in values])
        return estimate(values, is_larger_worse=quantity.is_larger_worse)

    def difference(self, cell: Cell, quantity: Quantity) -> Estimate | None:
        """Return how much larger a number is than with the first variant of its place, over the starts of both.

        None for the first itself, and where there is no pair.
        """
        base = self._base(cell)
        if base is None:
            return None
        first, second = self.values(base, quantity), self.values(cell, quantity)
        seeds = [seed for seed in self._pairs(base, cell) if seed in first and seed in second]
        return paired_difference([first[seed] for seed in seeds], [second[seed] for seed in seeds])

    def unlike_starts(self) -> int:
        """Return how many pairs did not start alike; they count in no difference (spec 14.8)."""
        based = [(base, cell) for cell in self.cells if (base := self._base(cell)) is not None]
        return sum(len(self._common(base, cell)) - len(self._pairs(base, cell)) for base, cell in based)

    def _base(self, cell: Cell) -> Cell | None:
        first = next(iter(self.at(cell.place)), None)
        return None if first is None or first.key == cell.key else first

    def _common(self, base: Cell, cell: Cell) -> list[int]:
        """Return the seeds of which both cells have a run with a start."""
        own, other = self._records[cell.key], self._records[base.key]
        return [seed for seed in own if seed in other and own[seed]["starts"] and other[seed]["starts"]]

    def _pairs(self, base: Cell, cell: Cell) -> list[int]:
        own, other = self._records[cell.key], self._records[base.key]
        return [seed for seed in self._common(base, cell) if own[seed]["starts"] == other[seed]["starts"]]
