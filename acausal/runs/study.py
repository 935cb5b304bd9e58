"""The results of a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, fail
from acausal.results.files import needs
from acausal.results.result import Ending, Result
from acausal.runs.job import Labels, Outcome, result_of
from acausal.runs.points import Point

if TYPE_CHECKING:
    import pandas
    import xarray


@dataclass(frozen=True, eq=False)
class Study:
    """The runs of a sweep, in the order of their points.

    ``study[k]`` is the :class:`~acausal.results.result.Result` of point ``k``, or None if there
    is none; ``study.errors`` says why.

    Attributes:
        points: What was varied: values by path, ``start(path)`` for start values.
        outcomes: What came of each point; None for points that were not run.
        labels: What all runs have in common.
        interrupted: The sweep was stopped before its end.

    Example:
        >>> study = sweep(compiled, {"r.R": [50, 100, 200]}, stop_time=0.1)
        >>> study.final("c.v")
        array([...])
    """

    points: Sequence[Point]
    outcomes: Sequence[Outcome | None]
    labels: Labels
    interrupted: bool = False

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, number: int) -> Result | None:
        outcome = self.outcomes[number]
        if outcome is None or not outcome.about:
            return None
        return result_of(outcome, self.points[number], self.labels)

    def __iter__(self) -> Iterator[Result | None]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        failed = len(self.errors)
        missing = sum(o is None for o in self.outcomes)
        more = f", {failed} failed" * bool(failed) + f", {missing} not run" * bool(missing)
        return f"<Study of {self.labels.model_name}: {len(self)} points{more}>"

    @property
    def errors(self) -> dict[int, Diagnostic]:
        """Why points have failed, by number of the point."""
        return {
            k: o.error for k, o in enumerate(self.outcomes) if o is not None and o.error is not None
        }

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Which points ran to their end, shape ``(points,)``."""
        good = (Ending.COMPLETE, Ending.TERMINATED)
        return np.array(
            [o is not None and o.about.get("ending") in good for o in self.outcomes], np.bool_
        )

    def final(self, path: str) -> NDArray[np.float64]:
        """Return a variable at the end of every run, NaN where there is none, ``(points,)``.

        Raises:
            AcausalError: ``N901`` if it was not kept.
        """
        return self.reduced(path, lambda times, values: float(values[-1]))

    def reduced(self, path: str, function: Any) -> NDArray[np.float64]:
        """Return one number for each run, NaN where there is none, shape ``(points,)``.

        Args:
            path: A variable.
            function: Called with times and values of a run, each of shape ``(nt,)``.

        Raises:
            AcausalError: ``N901`` if the variable was not kept.

        Example:
            >>> study.reduced("x", lambda t, x: x.max())
        """
        column = self._column(path)
        done = self.complete
        return np.array(
            [
                float(function(o.times, o.values[:, column])) if good and o is not None else np.nan
                for o, good in zip(self.outcomes, done, strict=True)
            ]
        )

    def _column(self, path: str) -> int:
        if path not in self.labels.paths:
            fail("N901", f"the sweep has kept no variable {path}",
                 help=f"it has {', '.join(self.labels.paths[:8])}")  # fmt: skip
        return self.labels.paths.index(path)

    def to_pandas(self) -> pandas.DataFrame:
        """Return a table of the points: what was varied, the ending, the final values.

        Raises:
            AcausalError: ``F205`` if pandas is not installed.
        """
        with needs("pandas", "data frames"):
            import pandas
        frame = pandas.DataFrame([dict(p) for p in self.points])
        frame.insert(0, "point", np.arange(len(self)))
        frame["ending"] = [
            "not run" if o is None else o.about["ending"].value if o.about else "failed"
            for o in self.outcomes
        ]
        finals = {f"{path} (final)": self.final(path) for path in self.labels.paths}
        return pandas.concat([frame, pandas.DataFrame(finals)], axis=1)

    def to_xarray(self) -> xarray.Dataset:
        """Return the trajectories over ``point`` and ``time``.

        Runs are interpolated linearly to the times of the first complete one if theirs differ.

        Raises:
            AcausalError: ``F205`` if xarray is not installed, ``F143`` if no run is complete.
        """
        with needs("xarray", "labelled arrays"):
            import xarray
        good = [o for o, ok in zip(self.outcomes, self.complete, strict=True) if ok]
        if not good or good[0] is None:
            fail("F143", "no point of the sweep ran to its end", help="look at study.errors")
        times = np.unique(good[0].times)
        table = np.full((len(self), len(times), len(self.labels.paths)), np.nan)
        for k, outcome in enumerate(self.outcomes):
            if outcome is None or not len(outcome.times):
                continue
            for j in range(table.shape[2]):
                table[k, :, j] = np.interp(
                    times, outcome.times, outcome.values[:, j], left=np.nan, right=np.nan
                )
        labels = self.labels
        names = dict.fromkeys(name for p in self.points for name in p)
        coordinates: dict[str, Any] = {"time": ("time", times, {"units": "s"})}
        for name in names:
            coordinates[name] = ("point", [p.get(name, np.nan) for p in self.points])
        return xarray.Dataset(
            {
                path: (("point", "time"), table[:, :, j], {
                    "units": labels.units.get(path, ""),
                    "long_name": labels.descriptions.get(path, ""),
                })
                for j, path in enumerate(labels.paths)
            },
            coordinates,
            {"model": labels.model_name},
        )  # fmt: skip
