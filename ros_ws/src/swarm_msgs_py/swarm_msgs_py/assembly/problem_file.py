"""Assembly problems as JSON documents: what the maps of the package and the files of users hold."""

from __future__ import annotations

import json
from collections.abc import Mapping

from swarm_msgs_py.assembly.faces import Cell, Gender, Layout
from swarm_msgs_py.assembly.problem import AssemblyProblem
from swarm_msgs_py.errors import AssemblyError

CELLS_MAX = 10_000
"""Most targets, or boats, that a file may name: far beyond what can be planned, so a wrong file is told at once."""

COORDINATE_MAX = 10_000
"""Largest cell index and grid side."""

_DOCK_ORDER = ["up", "down", "left", "right"]


def parse_problem(text: str, name: str, gender: Gender) -> AssemblyProblem:
    """Return the problem that a JSON document describes.

    Parameters
    ----------
    text : str
        An object with ``grid_size`` [columns, rows], ``cell_origin`` (index of the lowest cell, default 1),
        ``targets``, ``starts``, ``docks_genderless`` or ``docks_gendered``, and optionally ``dock_order``,
        ``extension_centre`` and ``extension_interval``.
    name : str
        File or map that it came from; begins every error.
    gender : Gender
        Which of the two lists of docks to use.

    Raises
    ------
    AssemblyError
        One line that names the document, the key, what is wrong and what to do.
    """
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise AssemblyError(f"{name}: not valid JSON ({error})") from None
    if not isinstance(record, Mapping):
        raise AssemblyError(f"{name}: expected an object with targets, starts and docks, got {_short(record)}")
    order = record.get("dock_order", _DOCK_ORDER)
    if order != _DOCK_ORDER:
        raise AssemblyError(f"{name}: dock_order is {_short(order)}; sides must be ordered up, down, left, right")
    lowest = _integer(record.get("cell_origin", 1), name, "cell_origin")
    targets = _cells(record, "targets", name)
    docks = f"docks_{gender.value}"
    return AssemblyProblem(
        name=name,
        origin=(lowest, lowest),
        size=_pair(_required(record, "grid_size", name), name, "grid_size"),
        targets=targets,
        starts=_cells(record, "starts", name),
        layouts=tuple(_layout(row, name, f"{docks}[{n + 1}]") for n, row in enumerate(_rows(record, docks, name))),
        gender=gender,
        center=_center(record, targets, (lowest, lowest), name),
        interval=_integer(record.get("extension_interval", 3), name, "extension_interval"),
    )


def nearest_to_centroid(cells: tuple[Cell, ...]) -> Cell:
    """Return the cell that is nearest to the centroid of `cells`, the least of several; it need not be one of them."""
    count = len(cells)
    # Half cells are rounded down, by whole numbers only: every machine finds the same cell.
    x, y = ((2 * sum(cell[axis] for cell in cells) + count - 1) // (2 * count) for axis in (0, 1))
    return x, y


def _center(record: Mapping[str, object], targets: tuple[Cell, ...], origin: Cell, name: str) -> Cell:
    if "extension_centre" in record:
        return _pair(record["extension_centre"], name, "extension_centre")
    return nearest_to_centroid(targets) if targets else origin


def _required(record: Mapping[str, object], key: str, name: str) -> object:
    if key not in record:
        raise AssemblyError(f"{name}: {key} is missing")
    return record[key]


def _rows(record: Mapping[str, object], key: str, name: str) -> list[object]:
    rows = _required(record, key, name)
    if not isinstance(rows, list):
        raise AssemblyError(f"{name}: {key} must be a list, got {_short(rows)}")
    if len(rows) > CELLS_MAX:
        raise AssemblyError(f"{name}: {key} has {len(rows)} entries; at most {CELLS_MAX} can be planned for")
    return rows


def _cells(record: Mapping[str, object], key: str, name: str) -> tuple[Cell, ...]:
    return tuple(_pair(row, name, f"{key}[{number + 1}]") for number, row in enumerate(_rows(record, key, name)))


def _pair(row: object, name: str, key: str) -> Cell:
    if not isinstance(row, list) or len(row) != 2:
        raise AssemblyError(f"{name}: {key} is {_short(row)}; it must be two whole numbers [x, y]")
    return _integer(row[0], name, key), _integer(row[1], name, key)


def _layout(row: object, name: str, key: str) -> Layout:
    if not isinstance(row, list) or len(row) != len(_DOCK_ORDER):
        raise AssemblyError(f"{name}: {key} is {_short(row)}; it must be four values: up, down, left, right")
    up, down, left, right = (_integer(side, name, key) for side in row)
    return up, down, left, right


def _integer(value: object, name: str, key: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise AssemblyError(f"{name}: {key} holds {_short(value)}; it must be a whole number")
    if abs(value) > COORDINATE_MAX:
        raise AssemblyError(f"{name}: {key} holds {_short(value)}; cells are numbered within {COORDINATE_MAX}")
    return value


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:37]}..."
