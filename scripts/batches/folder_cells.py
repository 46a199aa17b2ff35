"""The cells that a folder has results of: described beside the results, so that later commands know them too."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from batches.cells import TURNED, Cell, named_apart, seeds_by_cell
from bringup.scenario import Scenario
from bringup.scenario_file import dump_scenario, load_scenario
from studies.campaign_folder import write_files
from swarm_msgs_py.errors import ConfigError, SwarmError

CELLS = "cells"
"""Folder below that of the results: a scenario file per cell, which ``launch_swarm.py --scenario`` takes as well."""


def store_cells(out: Path, cells: Iterable[Cell]) -> None:
    """Write down what the runs of each cell are made of.

    Raises
    ------
    SwarmError
        If the disk does not take it.
    """
    folder = out / CELLS
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise SwarmError(f"{folder}: cannot be made ({error.strerror})") from None
    write_files(folder, {_file_name(cell.fingerprint): dump_scenario(_seedless(cell)).encode() for cell in cells})


def folder_cells(out: Path, wanted: Sequence[Cell], runs: Iterable[str]) -> tuple[tuple[Cell, ...], int]:
    """Return the cells of a command and then all others that a folder has results of, and how many are not known.

    Parameters
    ----------
    out : Path
    wanted : sequence of Cell
        Of the command.
    runs : iterable of str
        Keys of the runs that have results which count.

    Raises
    ------
    ConfigError
        If two of them have one name: a table could not tell them apart, and must not mix them.
    """
    keys = {cell.key for cell in wanted}
    others = [_load(out, key) for key in seeds_by_cell(runs) if key not in keys]
    known = [*wanted, *(cell for cell in others if cell is not None)]
    first: dict[tuple[str, ...], Cell] = {}
    for cell in known:
        if first.setdefault(cell.name, cell) is not cell:
            raise ConfigError(
                f"--out {out}: has results of '{', '.join(cell.name)}' with other settings (see {CELLS} there); give "
                "another folder"
            )
    return named_apart(known), len(wanted) + len(others) - len(known)


def _load(out: Path, key: str) -> Cell | None:
    """Return a cell by key; None if nothing, or nothing that this code understands, is written of it."""
    fingerprint = key.rpartition(", ")[2]
    try:
        scenario, origin = load_scenario(str(out / CELLS / _file_name(fingerprint)))
    except ConfigError:
        return None
    cell = Cell(scenario, origin, False, fingerprint)
    return cell if cell.key == key else None


def _file_name(fingerprint: str) -> str:
    return f"{fingerprint.removesuffix(TURNED)}.yaml"


def _seedless(cell: Cell) -> Scenario:
    return replace(cell.scenario, seed=0)
