"""Variables held as arrays in memory: what a result read from a file is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics.suggest import nearest
from acausal.results.patterns import matching


class TableSource:
    """A :class:`~acausal.results.result.VariableSource` over a dictionary of arrays.

    Args:
        columns: Values by path, each of shape ``(nt,)``.
        units: Unit texts by path; missing ones are empty.
        descriptions: Description strings by path; missing ones are empty.
    """

    def __init__(
        self,
        columns: Mapping[str, NDArray[np.float64]],
        units: Mapping[str, str] | None = None,
        descriptions: Mapping[str, str] | None = None,
    ) -> None:
        self._columns = columns
        self._units = units or {}
        self._descriptions = descriptions or {}

    def paths(self) -> Sequence[str]:
        """Return the paths in the order of the columns."""
        return list(self._columns)

    def find(self, pattern: str) -> list[str]:
        """Return the paths that match."""
        if pattern in self._columns:
            return [pattern]
        return matching(pattern, self._columns)

    def values(self, path: str) -> NDArray[np.float64]:
        """Return a column, shape ``(nt,)``.

        Raises:
            KeyError: If there is none.
        """
        return self._columns[path]

    def many(self, paths: Sequence[str]) -> NDArray[np.float64]:
        """Return several columns, shape ``(nt, len(paths))``.

        Raises:
            KeyError: If there is no such column.
        """
        return np.column_stack([self._columns[path] for path in paths])

    def unit(self, path: str) -> str:
        """Return the unit text."""
        return self._units.get(path, "")

    def description(self, path: str) -> str:
        """Return the description string."""
        return self._descriptions.get(path, "")

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths."""
        return nearest(path, self._columns)
