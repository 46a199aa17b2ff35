"""The numbers in which methods are compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from studies.campaign import Record

ACHIEVED = "achieved"


@dataclass(frozen=True, slots=True)
class Quantity:
    """One number of a run.

    Attributes
    ----------
    name : str
        A metric, or what `value_of` makes of several.
    label : str
        For people, with unit.
    is_larger_worse : bool
    is_drawn : bool
        Whether the figure has a panel of it.
    """

    name: str
    label: str
    is_larger_worse: bool = True
    is_drawn: bool = False


SETTLING_RATIO, SETTLING = "settling_ratio", "settling_time_s"
OF_SETTLED = frozenset({SETTLING_RATIO, SETTLING})
"""What only runs that settled have: who fails where it is hard looks fast, unless the share of these is beside it."""
QUANTITIES = (
    Quantity("displacement_ratio", "displacement / bound", is_drawn=True),
    Quantity(SETTLING_RATIO, "settling / bottleneck", is_drawn=True),
    Quantity("mesh_topological_interior", "eps_t, interior", is_drawn=True),
    Quantity("mesh_topological", "eps_t, all", is_drawn=True),
    Quantity("mesh_geometrical", "eps_g", is_drawn=True),
    Quantity("mesh_geometrical_cells", "eps_g of cells"),
    Quantity("cell_area_variation", "variation of cell areas"),
    Quantity("gap_variation", "variation of gaps"),
    Quantity("covered_fraction", "covered fraction", is_larger_worse=False),
    Quantity("inside_fraction", "robots inside", is_larger_worse=False),
    Quantity("total_displacement_m", "total displacement [m]"),
    Quantity(SETTLING, "settling time [s]"),
    Quantity("collisions", "collisions"),
    Quantity("min_clearance_m", "least clearance [m]", is_larger_worse=False),
    Quantity("morph_latency_s", "lag behind a moving shape [s]"),
)
SHARE = Quantity(ACHIEVED, "achieved", is_larger_worse=False)
"""The share of the runs that were achieved; of all runs, also those that were refused."""


def value_of(quantity: Quantity, record: Record) -> float | None:
    """Return one number of a run's record, None where it does not apply."""
    metrics = record["metrics"]
    assert isinstance(metrics, Mapping)  # as `Performed.as_record` makes it
    if quantity.name == SETTLING_RATIO:
        settled, bottleneck = metrics["settling_time_s"], metrics["bottleneck_time_s"]
        return settled / bottleneck if settled is not None and bottleneck else None
    value = metrics.get(quantity.name)
    return None if value is None else float(value)
