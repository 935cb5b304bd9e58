"""CSV: a header of paths, one row a time, and what the numbers mean in comment lines above.

::

    # model: RLC
    # units: s,V,A
    time,c.v,l.i
    0.0,0.0,0.0

Any program that skips lines starting with ``#`` reads it; ``pandas.read_csv(f, comment="#")``.
Only the standard library writes it: a small run must not wait for pandas to be imported.
"""

from __future__ import annotations

import csv
import io
import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import RawIOBase
from pathlib import Path
from typing import BinaryIO, TextIO

import numpy as np
from numpy.typing import NDArray

from acausal.results.metadata import fields, final_metadata, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource

Array = NDArray[np.float64]

#: Rows that are formatted at once.
BLOCK = 4096


def write_csv(result: Result, paths: Sequence[str], file: Path) -> None:
    """Write a CSV file; numbers read back exactly.

    Raises:
        OSError: If the file cannot be written.
    """
    with open(file, "w", encoding="utf-8", newline="") as out:
        write_rows(result, paths, out)


def write_rows(result: Result, paths: Sequence[str], out: TextIO) -> None:
    """Write the lines of a CSV file to an open stream."""
    source = result.variables
    paths = [path for path in paths if path != "time"]
    out.write(_head(result, paths))
    table = np.column_stack([result.times, source.many(paths)] if paths else [result.times])
    for first in range(0, len(table), BLOCK):
        out.write(_lines(table[first : first + BLOCK]))


def _head(result: Result, paths: Sequence[str]) -> str:
    source = result.variables
    descriptions = [" ".join(source.description(path).split()) for path in paths]
    return (
        _comments(metadata(result))
        + f"# units: {_row(['s', *map(source.unit, paths)])}\n"
        + f"# descriptions: {_row(['time', *descriptions])}\n"
        + _row(["time", *paths])
        + "\n"
    )


def _comments(data: Mapping[str, str]) -> str:
    return "".join(
        f"# {key}: {' '.join(value.splitlines())}\n"
        for key, value in data.items()
        if value and value not in ("{}", "[]")
    )


def _lines(rows: Array) -> str:
    plain = rows + 0.0  # turns -0.0 into 0.0
    return "".join([",".join(map(repr, row)) + "\n" for row in plain.tolist()])


class CSVStream:
    """Writes a CSV file in chunks; what is known at the end stands in comments below."""

    def __init__(self, file: BinaryIO | RawIOBase, head: Result, paths: Sequence[str]) -> None:
        self._file = file
        file.write(_head(head, paths).encode())

    def add(self, times: Array, values: Array) -> None:
        """Append rows."""
        for first in range(0, len(times), BLOCK):
            rows = slice(first, first + BLOCK)
            self._file.write(_lines(np.column_stack([times[rows], values[rows]])).encode())

    def finish(self, result: Result) -> None:
        """Write events, statistics and the ending."""
        self._file.write(_comments(final_metadata(result)).encode())


def columns(file: Path, paths: Sequence[str]) -> Array:
    """Return some columns, shape ``(nt, len(paths))``.

    Raises:
        ValueError: If there is no such column.
    """
    with open(file, encoding="utf-8-sig", newline="") as text:
        header = _cells(next(line for line in text if not line.startswith("#")))
        places = [header.index(path) for path in paths]
        rows = _complete(text, {})
        return np.loadtxt(rows, delimiter=",", ndmin=2, usecols=places).reshape(-1, len(places))


def _complete(text: Iterable[str], data: dict[str, str]) -> Iterator[str]:
    """Yield the rows; comments go to ``data``, half a row (a run that was killed) is left out."""
    for line in text:
        if line.startswith("#"):
            key, _, value = line[1:].partition(":")
            data[key.strip()] = value.strip()
        elif line.endswith("\n") or line.strip() == "":
            yield line


def read_csv(file: Path) -> Result:
    """Read a CSV file, with or without the comment lines.

    Raises:
        OSError: If it cannot be read.
        ValueError: If it is no table of numbers with a column ``time``.
    """
    data: dict[str, str] = {}
    with open(file, encoding="utf-8-sig", newline="") as text:
        line = text.readline()
        while line.startswith("#"):
            key, _, value = line[1:].partition(":")
            data[key.strip()] = value.strip()
            line = text.readline()
        header = _cells(line)
        if "time" not in header:
            raise ValueError("it has no column 'time'")
        rows = _complete(text, data)
        first = next(rows, "")
        table = np.empty((0, len(header)))
        if first.strip():
            every = itertools.chain([first], rows)
            table = np.loadtxt(every, delimiter=",", ndmin=2, dtype=np.float64)
    if table.shape[1] != len(header):
        raise ValueError(f"it has {len(header)} names above {table.shape[1]} columns")
    columns = dict(zip(header, table.T, strict=True))
    units = dict(zip(header, _cells(data.get("units", "")), strict=False))
    descriptions = dict(zip(header, _cells(data.get("descriptions", "")), strict=False))
    times = columns.pop("time")
    return Result(times=times, variables=TableSource(columns, units, descriptions), **fields(data))


def _row(cells: Sequence[str]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="").writerow(cells)
    return buffer.getvalue()


def _cells(line: str) -> list[str]:
    return next(csv.reader([line.rstrip("\r\n")]), [])
