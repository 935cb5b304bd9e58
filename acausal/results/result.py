"""What a simulation returns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any, NoReturn, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acausal.diagnostics import Diagnostic, fail
from acausal.results.patterns import is_pattern
from acausal.results.trajectory import Trajectory

if TYPE_CHECKING:
    import os

    import pandas
    import xarray
    from matplotlib.figure import Figure

    from acausal.results.snapshot import Snapshot


class VariableSource(Protocol):
    """Where a result gets its variables from. Nothing is computed or named before it is asked."""

    def paths(self) -> Sequence[str]:
        """Return the paths of all variables, in the order of declaration."""
        ...

    def find(self, pattern: str) -> list[str]:
        """Return the paths that match a pattern or are equal to it, in order."""
        ...

    def values(self, path: str) -> NDArray[np.float64]:
        """Return a variable's values, SI units, shape ``(nt,)``.

        Raises:
            KeyError: If there is no such variable.
        """
        ...

    def many(self, paths: Sequence[str]) -> NDArray[np.float64]:
        """Return the values of several variables at once, shape ``(nt, len(paths))``.

        Raises:
            KeyError: If one of them does not exist.
        """
        ...

    def unit(self, path: str) -> str:
        """Return the unit text, empty if it has none."""
        ...

    def description(self, path: str) -> str:
        """Return the description string."""
        ...

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths to a misspelt one, best first."""
        ...


class Dense(Protocol):
    """The solver's own polynomials of a whole run."""

    def at(
        self, paths: Sequence[str], times: NDArray[np.float64], before: bool
    ) -> NDArray[np.float64]:
        """Return variables at any times, shape ``(len(times), len(paths))``.

        Args:
            paths: The variables.
            times: Inside the run, seconds.
            before: Whether the value before an event is meant at its time.

        Raises:
            KeyError: If there is no such variable.
        """
        ...


class Ending(Enum):
    """How a simulation ended."""

    COMPLETE = "complete"
    TERMINATED = "terminated"
    INTERRUPTED = "interrupted"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened at one time.

    Attributes:
        time: When, seconds.
        text: What, in the words of the model.
    """

    time: float
    text: str


@dataclass(frozen=True, eq=False)
class Result:
    """A simulation's trajectories, and what belongs to them.

    ``result["c.v"]`` is one :class:`Trajectory`; ``result["link[*].angle"]`` a dictionary of them.

    Attributes:
        model_name: Name of the model.
        description: Its description string.
        times: Times of the stored points, seconds, shape ``(nt,)``.
        variables: Source of the variables.
        states: Paths of the states, the first choice for a plot.
        parameters: Values of the parameters, SI units, by path. May be a lazy mapping.
        events: What happened, in order of time.
        statistics: Counts and times of the solver (``steps``, ``residual_evaluations``, ...).
        experiment: What was asked for: ``start_time``, ``stop_time``, ``tolerance``, ``solver``.
        ending: Whether it ran to its end.
        diagnostics: Warnings, and why it failed if it did.
        end: Where the run stood at last; None if it failed.
        parameter_units: Unit texts of the parameters by path, where they have any.
        dense: The solver's own polynomials, if the run has kept them.
        compiled: The compiled model it came from, which knows how components look; None for
            results that were read from files.
    """

    model_name: str
    description: str
    times: NDArray[np.float64]
    variables: VariableSource
    states: Sequence[str] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)
    events: Sequence[Event] = ()
    statistics: Mapping[str, float | int | str] = field(default_factory=dict)
    experiment: Mapping[str, float | int | str] = field(default_factory=dict)
    ending: Ending = Ending.COMPLETE
    diagnostics: tuple[Diagnostic, ...] = ()
    end: Snapshot | None = None
    parameter_units: Mapping[str, str] = field(default_factory=dict)
    dense: Dense | None = field(default=None, repr=False)
    compiled: Any = field(default=None, repr=False)

    def __getitem__(self, path: str) -> Any:
        """Return a :class:`Trajectory`, or a dictionary of them by path.

        A dictionary is returned for a pattern and for an array (a missing subscript).

        Raises:
            AcausalError: ``N901`` if there is no such variable.
        """
        found = self.variables.find(path)
        if found != [path] and (is_pattern(path) or len(found) > 1):
            return self.select(path)
        return self.trajectory(path)

    def __contains__(self, path: object) -> bool:
        if not isinstance(path, str):
            return False
        try:
            self.variables.values(path)
        except KeyError:
            return path == "time"
        return True

    def trajectory(self, path: str) -> Trajectory:
        """Return one variable over time; ``time`` is one too.

        Raises:
            AcausalError: ``N901`` if there is no such variable.
        """
        try:
            values = self.variables.values(path)
        except KeyError:
            if path == "time":
                return Trajectory("time", self.times, self.times, "s", "time")
            self._no_such(path)
        source = self.variables
        curve = None if self.dense is None else partial(_column, self.dense, path)
        return Trajectory(
            path, self.times, values, source.unit(path), source.description(path), curve
        )

    def evaluate(self, expression: str) -> Any:
        """Return an expression of variables and parameters over time, in the language of models.

        Units are checked and carried; arrays, subscripts, conditions and the functions of the
        language and of the library may be used, and ``der(...)`` of states.

        Returns:
            A :class:`Trajectory` in SI units; for an array a dictionary of its elements.

        Raises:
            AcausalError: ``N901`` for an unknown name, ``U1xx`` and ``T1xx`` for units, types
                and sizes that do not fit, ``P0xx`` for what cannot be read.

        Example:
            >>> result.evaluate("c.v*r.i + 2[W]").max()
        """
        from acausal.results.expressions import evaluate

        return evaluate(self, expression)

    def at(self, time: ArrayLike, *names: str, side: str = "after") -> Any:
        """Return variables or expressions at any time.

        The solver's own polynomials give them if the run has kept them
        (``simulate(dense=True)``), else they are linear between the stored points.

        Args:
            time: One time or several, seconds.
            names: Paths, patterns or expressions.
            side: Which values are meant at an event, those ``"before"`` or ``"after"`` it.

        Returns:
            A number, or an array of the shape of ``time``; for several variables a dictionary.

        Raises:
            AcausalError: ``F211`` if a time lies outside of the run, and as :meth:`evaluate`.

        Example:
            >>> result.at(0.0123, "c.v")
        """
        from acausal.results.expressions import chosen

        found = {x.path: x(np.asarray(time), side) for x in chosen(self, names)}
        return found[names[0]] if list(found) == list(names) and len(names) == 1 else found

    def find(self, *patterns: str) -> list[str]:
        """Return the paths that match any of the patterns, each once; all paths without patterns.

        Raises:
            AcausalError: ``N901`` if a pattern matches nothing.
        """
        if not patterns:
            return list(self.variables.paths())
        found: dict[str, None] = {}
        for pattern in patterns:
            matches = self.variables.find(pattern)
            if not matches and pattern != "time":
                self._no_such(pattern)
            found.update(dict.fromkeys(matches or ["time"]))
        return list(found)

    def select(self, *patterns: str) -> dict[str, Trajectory]:
        """Return the trajectories that match any of the patterns, by path.

        Raises:
            AcausalError: ``N901`` if a pattern matches nothing.
        """
        return {path: self.trajectory(path) for path in self.find(*patterns)}

    def matrix(self, *patterns: str) -> NDArray[np.float64]:
        """Return the values of all matching variables, shape ``(nt, number of variables)``.

        Raises:
            AcausalError: ``N901`` if a pattern matches nothing.
        """
        paths = self.find(*patterns)
        if "time" not in paths or "time" in self.variables.find("time"):
            return self.variables.many(paths)
        place = paths.index("time")
        others = self.variables.many([*paths[:place], *paths[place + 1 :]])
        return np.insert(others, place, self.times, axis=1)

    def to_pandas(self, *patterns: str) -> pandas.DataFrame:
        """Return a data frame with the time as index; ``frame.attrs["units"]`` has the units.

        Raises:
            AcausalError: ``N901`` for an unknown name, ``F205`` if pandas is not installed.
        """
        from acausal.results.frames import to_pandas

        return to_pandas(self, patterns)

    def to_xarray(self, *patterns: str) -> xarray.Dataset:
        """Return a data set over the dimension ``time``, with units as attributes.

        Raises:
            AcausalError: ``N901`` for an unknown name, ``F205`` if xarray is not installed.
        """
        from acausal.results.frames import to_xarray

        return to_xarray(self, patterns)

    def write(self, path: str | os.PathLike[str], *patterns: str) -> None:
        """Write a file; its suffix says which sort (``.csv .nc .h5 .parquet``).

        Raises:
            AcausalError: ``F20x`` if it cannot be written, ``N901`` for an unknown name.
        """
        from acausal.results.files import write_result

        write_result(self, path, patterns)

    def plot(
        self,
        *patterns: str,
        file: str | os.PathLike[str] | None = None,
        title: str = "",
        events: bool = False,
    ) -> Figure:
        """Draw variables or expressions over time, those of like unit in one set of axes.

        Args:
            patterns: Paths, patterns or expressions; the states if there are none.
            file: Where to write the picture (``.png .svg .pdf``), if anywhere.
            title: Text above; the model's name and description if empty.
            events: Whether events are marked by dashed lines.

        Raises:
            AcausalError: ``N901`` for an unknown name, ``F20x`` if the file cannot be written.
        """
        from acausal.results.plot import draw, write_figure

        figure = draw(self, patterns, title, events)
        if file is not None:
            write_figure(figure, file)
        return figure

    def plot_phase(
        self, x: str, y: str, file: str | os.PathLike[str] | None = None, title: str = ""
    ) -> Figure:
        """Draw one variable or expression over another.

        Args:
            x: What goes to the right.
            y: What goes up.
            file: Where to write the picture (``.png .svg .pdf``), if anywhere.
            title: Text above; the model's name and description if empty.

        Raises:
            AcausalError: As :meth:`plot`, and ``F213`` if one of them means several variables.

        Example:
            >>> result.plot_phase("pendulum.phi", "pendulum.w", file="phase.svg")
        """
        from acausal.results.plot import draw_phase, write_figure

        figure = draw_phase([self], x, y, title)
        if file is not None:
            write_figure(figure, file)
        return figure

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        from acausal.results.display import result_html

        return result_html(self)

    def animate(self, file: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """Animate the components that have shapes; a notebook shows what is returned.

        Args:
            file: ``.html`` (play, pause, scrub, works offline), ``.gif`` or ``.mp4``, if any.
            options: ``fps``, ``speed``, ``width``, ``height``, ``title``, ``camera``, see
                :func:`acausal.animation.animation.animate`.

        Returns:
            The :class:`~acausal.animation.animation.Animation`; more shapes can be added to it.

        Raises:
            AcausalError: ``D11x`` if nothing can be drawn, ``F20x`` if the file cannot be written.
        """
        # Only a method on results makes animations easy to find; results know nothing of them.
        from importlib import import_module

        return import_module("acausal.animation.animation").animate(self, file, **options)

    def __repr__(self) -> str:
        span = f", {self.times[0]:g} s to {self.times[-1]:g} s" if len(self.times) else ""
        return f"<Result of {self.model_name}: {self.ending.value}, {len(self.times)} points{span}>"

    def _no_such(self, path: str) -> NoReturn:
        near = [] if is_pattern(path) else self.variables.suggestions(path)
        what = "matches" if is_pattern(path) else "is called"
        fail(
            "N901",
            f"no variable of {self.model_name} {what} '{path}'",
            notes=[f"did you mean {' or '.join(near[:3])}?"] if near else [],
            help=(
                f"write {near[0]}, if that is what you mean"
                if near
                else "acausal inspect MODEL --stage flatten lists the variables; "
                "* stands for any text"
            ),
        )


def _column(
    dense: Dense, path: str, times: NDArray[np.float64], before: bool
) -> NDArray[np.float64]:
    return dense.at([path], times, before)[:, 0]


def plot_runs(
    runs: Iterable[Result | None],
    *patterns: str,
    labels: Sequence[str] | None = None,
    file: str | os.PathLike[str] | None = None,
    title: str = "",
) -> Figure:
    """Draw variables of several runs over each other.

    Args:
        runs: Results, or a study, whose points are then the labels.
        patterns: Paths, patterns or expressions; the states of the first run if there are none.
        labels: Names of the runs.
        file: Where to write the picture (``.png .svg .pdf``), if anywhere.
        title: Text above; the model's name and description if empty.

    Raises:
        AcausalError: ``N901`` for an unknown name, ``F213`` if there is no run or not one label
            for each, ``F20x`` if the file cannot be written.

    Example:
        >>> plot_runs(sweep(compiled, {"r.R": [50, 100, 200]}), "c.v", file="sweep.png")
    """
    from acausal.results.plot import draw_runs, write_figure

    figure = draw_runs(runs, patterns, labels, title)
    if file is not None:
        write_figure(figure, file)
    return figure
