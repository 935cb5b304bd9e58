"""Results as pandas data frames and xarray data sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from acausal.results.families import families
from acausal.results.files import needs
from acausal.results.metadata import metadata
from acausal.results.result import Result

if TYPE_CHECKING:
    import pandas
    import xarray


def to_pandas(result: Result, patterns: Sequence[str]) -> pandas.DataFrame:
    """Return a data frame: index ``time`` in seconds, one column a variable."""
    with needs("pandas", "data frames"):
        import pandas

    paths = [path for path in result.find(*patterns) if path != "time"]
    index = pandas.Index(result.times, name="time")
    frame = pandas.DataFrame(
        result.variables.many(paths) if paths else None, index=index, columns=paths
    )
    frame.attrs.update(metadata(result))
    frame.attrs["units"] = {path: result.variables.unit(path) for path in paths}
    return frame


def to_xarray(result: Result, patterns: Sequence[str]) -> xarray.Dataset:
    """Return a data set over ``time``; each variable has ``units`` and ``long_name``.

    Variables that differ only in subscripts are one array, as in NetCDF files.
    """
    with needs("xarray", "data sets"):
        import xarray

    paths = [path for path in result.find(*patterns) if path != "time"]
    arrays: dict[str, Any] = {}
    coordinates: dict[str, Any] = {
        "time": ("time", result.times, {"units": "s", "long_name": "time"})
    }
    for family in families(paths, result.variables):
        about = {"units": family.unit, "long_name": family.description}
        values = result.variables.many(family.paths)
        if family.single:
            arrays[family.name] = ("time", values[:, 0], about)
        else:
            arrays[family.name] = (("time", family.labels), values, about)
            coordinates[family.labels] = list(family.paths)
    return xarray.Dataset(arrays, coords=coordinates, attrs=metadata(result))
