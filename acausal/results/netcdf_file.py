"""NetCDF 4, which is HDF5 too: one array a variable family, over the dimension ``time``.

``c.v`` is a variable of shape ``(nt,)``; ``link[1].angle`` and its like are one variable
``link[*].angle`` of shape ``(nt, members)``, with the members' paths as coordinate. xarray, MATLAB
and every HDF5 program read it.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import RawIOBase
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail
from acausal.results.families import families
from acausal.results.files import needs
from acausal.results.metadata import fields, final_metadata, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource

Array = NDArray[np.float64]

#: Rows of a piece of a growing file; one that is not full takes its whole space.
CHUNK_ROWS = 512


def write_netcdf(result: Result, paths: Sequence[str], file: Path) -> None:
    """Write a NetCDF file.

    Raises:
        AcausalError: ``F205`` if h5netcdf is missing.
        OSError: If the file cannot be written.
    """
    h5netcdf = _library()
    source = result.variables
    with h5netcdf.File(file, "w", track_order=True) as out:
        out.attrs.update(metadata(result))
        out.dimensions = {"time": len(result.times)}
        time = out.create_variable("time", ("time",), data=result.times)
        time.attrs["units"] = "s"
        time.attrs["long_name"] = "time"
        for family in families(paths, source):
            dimensions: tuple[str, ...] = ("time",)
            data = source.many(family.paths)
            if family.single:
                data = data[:, 0]
            else:
                dimensions = ("time", family.labels)
                out.dimensions[family.labels] = len(family.paths)
                labels = np.array(family.paths, dtype=object)
                out.create_variable(family.labels, (family.labels,), _text_type(), data=labels)
            variable = out.create_variable(family.name, dimensions, data=data)
            if family.unit:
                variable.attrs["units"] = family.unit
            if family.description:
                variable.attrs["long_name"] = family.description


class NetCDFStream:
    """Writes a NetCDF file in chunks, along a dimension ``time`` without limit."""

    def __init__(self, file: RawIOBase, head: Result, paths: Sequence[str]) -> None:
        self._rows = 0
        places = {path: k for k, path in enumerate(paths)}
        library = _library()
        import h5py

        # Kept at hand: h5netcdf's own flush() leaves HDF5's buffers as they are.
        self._stored = h5py.File(file, "w", track_order=True)
        self._out = out = library.File(self._stored, "w")
        out.attrs.update(metadata(head))
        out.dimensions = {"time": None}
        self._time = out.create_variable("time", ("time",), "f8", chunks=(CHUNK_ROWS,))
        self._time.attrs["units"] = "s"
        self._time.attrs["long_name"] = "time"
        self._variables: list[tuple[Any, NDArray[np.int64]]] = []
        for family in families(paths, head.variables):
            count = len(family.paths)
            dimensions: tuple[str, ...] = ("time",)
            chunks: tuple[int, ...] = (CHUNK_ROWS,)
            if not family.single:
                dimensions = ("time", family.labels)
                chunks = (max(1, CHUNK_ROWS // count), count)
                out.dimensions[family.labels] = count
                labels = np.array(family.paths, dtype=object)
                out.create_variable(family.labels, (family.labels,), _text_type(), data=labels)
            variable = out.create_variable(family.name, dimensions, "f8", chunks=chunks)
            if family.unit:
                variable.attrs["units"] = family.unit
            if family.description:
                variable.attrs["long_name"] = family.description
            self._variables.append((variable, np.array([places[p] for p in family.paths])))
        self._stored.flush()

    def add(self, times: Array, values: Array) -> None:
        """Append rows; the file is readable up to here if the process is killed."""
        first, last = self._rows, self._rows + len(times)
        self._out.resize_dimension("time", last)
        self._time[first:last] = times
        for variable, places in self._variables:
            rows = values[:, places]
            variable[first:last] = rows[:, 0] if len(variable.dimensions) == 1 else rows
        self._rows = last
        self._stored.flush()

    def finish(self, result: Result) -> None:
        """Write the ending and close the file."""
        self._out.attrs.update(final_metadata(result))
        self._out.close()
        self._stored.close()


def columns(file: Path, paths: Sequence[str]) -> Array:
    """Return some columns, shape ``(nt, len(paths))``.

    Raises:
        KeyError: If there is no such column.
    """
    found: dict[str, Array] = {}
    wanted = set(paths)
    with _library().File(file, "r") as stored:
        for name, variable in stored.variables.items():
            if variable.dimensions[:1] != ("time",):
                continue
            if len(variable.dimensions) == 1:
                if name in wanted:
                    found[name] = np.asarray(variable[...], dtype=np.float64)
                continue
            labels = [_text(label) for label in stored.variables[variable.dimensions[1]][...]]
            own = [k for k, label in enumerate(labels) if label in wanted]
            if own:
                values = np.asarray(variable[...], dtype=np.float64)
                found.update({labels[k]: values[:, k] for k in own})
    return np.column_stack([found[path] for path in paths])


def read_netcdf(file: Path) -> Result:
    """Read a NetCDF file.

    Raises:
        AcausalError: ``F204`` if it has no times, ``F205`` if h5netcdf is missing.
        OSError: If it cannot be read.
    """
    h5netcdf = _library()
    found: dict[str, Any] = {}
    units: dict[str, str] = {}
    descriptions: dict[str, str] = {}
    with h5netcdf.File(file, "r") as stored:
        if "time" not in stored.variables:
            fail("F204", f"'{file}' is no result file of acausal: it has no variable 'time'")
        for name, variable in stored.variables.items():
            if variable.dimensions[:1] != ("time",):
                continue
            values = np.asarray(variable[...], dtype=np.float64)
            paths = [name]
            if values.ndim == 1:
                values = values[:, np.newaxis]
            else:
                paths = [_text(label) for label in stored.variables[variable.dimensions[1]][...]]
            found.update(zip(paths, values.T, strict=True))
            units.update(dict.fromkeys(paths, str(variable.attrs.get("units", ""))))
            about = str(variable.attrs.get("long_name", ""))
            descriptions.update(dict.fromkeys(paths, about))
        data = {str(key): value for key, value in stored.attrs.items()}
    times = found.pop("time")
    return Result(times=times, variables=TableSource(found, units, descriptions), **fields(data))


def _text_type() -> Any:
    import h5py

    return h5py.string_dtype()


def _text(label: Any) -> str:
    return label.decode() if isinstance(label, bytes) else str(label)


def _library() -> Any:
    with needs("h5netcdf", "NetCDF and HDF5 files"):
        import h5netcdf
    return h5netcdf
