"""NetCDF 4, which is HDF5 too: one array a variable family, over the dimension ``time``.

``c.v`` is a variable of shape ``(nt,)``; ``link[1].angle`` and its like are one variable
``link[*].angle`` of shape ``(nt, members)``, with the members' paths as coordinate. xarray, MATLAB
and every HDF5 program read it.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from acausal.diagnostics import fail
from acausal.results.families import families
from acausal.results.files import needs
from acausal.results.metadata import fields, metadata
from acausal.results.result import Result
from acausal.results.table import TableSource


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


def read_netcdf(file: Path) -> Result:
    """Read a NetCDF file.

    Raises:
        AcausalError: ``F204`` if it has no times, ``F205`` if h5netcdf is missing.
        OSError: If it cannot be read.
    """
    h5netcdf = _library()
    columns: dict[str, Any] = {}
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
            columns.update(zip(paths, values.T, strict=True))
            units.update(dict.fromkeys(paths, str(variable.attrs.get("units", ""))))
            about = str(variable.attrs.get("long_name", ""))
            descriptions.update(dict.fromkeys(paths, about))
        data = {str(key): value for key, value in stored.attrs.items()}
    times = columns.pop("time")
    return Result(times=times, variables=TableSource(columns, units, descriptions), **fields(data))


def _text_type() -> Any:
    import h5py

    return h5py.string_dtype()


def _text(label: Any) -> str:
    return label.decode() if isinstance(label, bytes) else str(label)


def _library() -> Any:
    with needs("h5netcdf", "NetCDF and HDF5 files"):
        import h5netcdf
    return h5netcdf
