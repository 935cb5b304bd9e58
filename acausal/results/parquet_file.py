"""Parquet: one column a path, units and descriptions in the metadata of the columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from acausal.results.files import needs
from acausal.results.metadata import fields, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource


def write_parquet(result: Result, paths: Sequence[str], file: Path) -> None:
    """Write a Parquet file.

    Raises:
        AcausalError: ``F205`` if pyarrow is missing.
        OSError: If the file cannot be written.
    """
    pyarrow, parquet = _library()
    source = result.variables
    labels = [("time", "s", "time")]
    labels += [(path, source.unit(path), source.description(path)) for path in paths]
    schema = pyarrow.schema(
        [
            pyarrow.field(
                path, pyarrow.float64(), metadata={"unit": unit, "description": description}
            )
            for path, unit, description in labels
        ],
        metadata=metadata(result),
    )
    columns = [result.times, *(np.ascontiguousarray(source.values(path)) for path in paths)]
    parquet.write_table(pyarrow.table(columns, schema=schema), str(file))


def read_parquet(file: Path) -> Result:
    """Read a Parquet file.

    Raises:
        AcausalError: ``F205`` if pyarrow is missing.
        OSError: If it cannot be read.
        KeyError: If it has no column ``time``.
    """
    _, parquet = _library()
    table = parquet.read_table(str(file))
    columns = {
        name: table.column(name).to_numpy().astype(np.float64) for name in table.column_names
    }
    units: dict[str, str] = {}
    descriptions: dict[str, str] = {}
    for field in table.schema:
        about = field.metadata or {}
        units[field.name] = about.get(b"unit", b"").decode()
        descriptions[field.name] = about.get(b"description", b"").decode()
    data = {k.decode(): v.decode() for k, v in (table.schema.metadata or {}).items()}
    times = columns.pop("time")
    return Result(times=times, variables=TableSource(columns, units, descriptions), **fields(data))


def _library() -> tuple[Any, Any]:
    with needs("pyarrow", "Parquet files"):
        import pyarrow
        from pyarrow import parquet
    return pyarrow, parquet
