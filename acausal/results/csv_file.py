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
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from acausal.results.metadata import fields, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource

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
    for key, value in metadata(result).items():
        if value and value not in ("{}", "[]"):
            out.write(f"# {key}: {' '.join(value.splitlines())}\n")
    out.write(f"# units: {_row(['s', *map(source.unit, paths)])}\n")
    descriptions = [" ".join(source.description(path).split()) for path in paths]
    out.write(f"# descriptions: {_row(['time', *descriptions])}\n")
    out.write(_row(["time", *paths]) + "\n")
    table = np.column_stack([result.times, source.many(paths)] if paths else [result.times])
    table += 0.0  # turns -0.0 into 0.0
    for first in range(0, len(table), BLOCK):
        rows = table[first : first + BLOCK].tolist()
        out.write("".join([",".join(map(repr, row)) + "\n" for row in rows]))


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
        first = text.readline()
        table = np.empty((0, len(header)))
        if first.strip():
            rows = itertools.chain([first], text)
            table = np.loadtxt(rows, delimiter=",", ndmin=2, dtype=np.float64)
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
