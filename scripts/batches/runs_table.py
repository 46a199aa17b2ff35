"""All runs of a batch as one Parquet table, for whoever wants to look at them with other tools."""

from __future__ import annotations

import io
import typing
from collections.abc import Iterable, Mapping
from dataclasses import fields
from types import NoneType, UnionType
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from batches.cells import Run
from bringup.results import FormationMetrics
from studies.campaign import Record

_TYPES = {str: pa.string(), bool: pa.bool_(), int: pa.int64(), float: pa.float64()}
_OWN = {"run": str, "shape": str, "objective": str, "starts": str, "code_version": str, "run_s": float}
"""Columns beside the metrics: key of the run; fingerprint of its starts; all that it took [s]."""


def runs_parquet(runs: Iterable[Run], records: Mapping[str, Record], versions: Mapping[str, str]) -> bytes:
    """Return the table of those runs that have results, one row each.

    Columns have the same types whatever the runs came to, so that tables of several batches can be joined.

    Parameters
    ----------
    runs : iterable of Run
    records : mapping
        Results by key of run.
    versions : mapping
        Version of the code that made each.
    """
    rows = [_row(run, records[run.key], versions[run.key]) for run in runs if run.key in records]
    buffer = io.BytesIO()
    parquet.write_table(pa.Table.from_pylist(rows, schema=_schema()), buffer)
    return buffer.getvalue()


def _schema() -> pa.Schema:
    hints = typing.get_type_hints(FormationMetrics)
    metrics = [(field.name, _column(_plain(hints[field.name]))) for field in fields(FormationMetrics)]
    return pa.schema([*metrics, *((name, _TYPES[kind]) for name, kind in _OWN.items())])


def _plain(hint: Any) -> Any:
    """Return the type of what is not None."""
    is_union = typing.get_origin(hint) in {UnionType, typing.Union}
    (kind,) = [kind for kind in (typing.get_args(hint) if is_union else (hint,)) if kind is not NoneType]
    return kind


def _column(kind: Any) -> pa.DataType:
    """Return the type of a column; metrics are plain numbers, texts, truth values, and lists of these."""
    if typing.get_origin(kind) is tuple:
        return pa.list_(_column(_plain(typing.get_args(kind)[0])))
    return _TYPES[kind]


def _row(run: Run, record: Record, version: str) -> dict[str, object]:
    metrics, timing = record["metrics"], record["timing"]
    assert isinstance(metrics, Mapping) and isinstance(timing, Mapping)  # noqa: PT018 - as `Performed.as_record` makes it
    own = {"run": run.key, "shape": run.cell.place[1], "objective": run.cell.objective}
    return {**metrics, **timing, **own, "starts": record["starts"], "code_version": version}
