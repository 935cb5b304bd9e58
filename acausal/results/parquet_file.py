"""Parquet: one column a path, units and descriptions in the metadata of the columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import RawIOBase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.results.files import needs
from acausal.results.metadata import fields, final_metadata, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource

Array = NDArray[np.float64]


def write_parquet(result: Result, paths: Sequence[str], file: Path) -> None:
    """Write a Parquet file.

    Raises:
        AcausalError: ``F205`` if pyarrow is missing.
        OSError: If the file cannot be written.
    """
    pyarrow, parquet = _library()
    source = result.variables
    schema = _schema(pyarrow, result, paths, metadata(result))
    arrays = [result.times, *(np.ascontiguousarray(source.values(path)) for path in paths)]
    parquet.write_table(pyarrow.table(arrays, schema=schema), str(file))


def _schema(pyarrow: Any, result: Result, paths: Sequence[str], data: Mapping[str, str]) -> Any:
    source = result.variables
    labels = [("time", "s", "time")]
    labels += [(path, source.unit(path), source.description(path)) for path in paths]
    return pyarrow.schema(
        [
            pyarrow.field(
                path, pyarrow.float64(), metadata={"unit": unit, "description": description}
            )
            for path, unit, description in labels
        ],
        metadata=data,
    )


class ParquetStream:
    """Writes a Parquet file in chunks, one row group each; the end of the file tells of them."""

    def __init__(self, file: RawIOBase, head: Result, paths: Sequence[str]) -> None:
        self._pyarrow, parquet = _library()
        data = {k: v for k, v in metadata(head).items() if k not in final_metadata(head)}
        self._schema = _schema(self._pyarrow, head, paths, data)
        self._writer = parquet.ParquetWriter(self._pyarrow.PythonFile(file, "w"), self._schema)

    def add(self, times: Array, values: Array) -> None:
        """Append a row group."""
        arrays = [np.ascontiguousarray(column) for column in (times, *values.T)]
        self._writer.write_table(self._pyarrow.table(arrays, schema=self._schema))

    def finish(self, result: Result) -> None:
        """Write the end of the file."""
        self._writer.add_key_value_metadata(final_metadata(result))
        self._writer.close()


def columns(file: Path, paths: Sequence[str]) -> Array:
    """Return some columns, shape ``(nt, len(paths))``.

    Raises:
        KeyError: If there is no such column.
    """
    _, parquet = _library()
    table = _table(parquet, file, paths)
    return np.column_stack([table.column(path).to_numpy() for path in paths])


def _table(parquet: Any, file: Path, paths: Sequence[str] | None = None) -> Any:
    # Not read_table: a folder of data sets is not meant, and dots in names are no structure.
    with parquet.ParquetFile(str(file)) as stored:
        return stored.read() if paths is None else stored.read(columns=list(paths))


def read_parquet(file: Path) -> Result:
    """Read a Parquet file.

    Raises:
        AcausalError: ``F205`` if pyarrow is missing.
        OSError: If it cannot be read.
        KeyError: If it has no column ``time``.
    """
    _, parquet = _library()
    table = _table(parquet, file)
    found = {name: table.column(name).to_numpy().astype(np.float64) for name in table.column_names}
    units: dict[str, str] = {}
    descriptions: dict[str, str] = {}
    for field in table.schema:
        about = field.metadata or {}
        units[field.name] = about.get(b"unit", b"").decode()
        descriptions[field.name] = about.get(b"description", b"").decode()
    ended = parquet.read_metadata(str(file)).metadata or {}
    ended = {k: v for k, v in ended.items() if k != b"ARROW:schema"}
    data = {k.decode(): v.decode() for k, v in (ended | (table.schema.metadata or {})).items()}
    times = found.pop("time")
    return Result(times=times, variables=TableSource(found, units, descriptions), **fields(data))


def _library() -> tuple[Any, Any]:
    with needs("pyarrow", "Parquet files"):
        import pyarrow
        from pyarrow import parquet
    return pyarrow, parquet
