"""One variable over time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from acausal.diagnostics import fail
from acausal.results import arithmetic, measures
from acausal.results.measures import Extreme, Jump

#: From times, shape ``(k,)``, and whether the value before an event is meant, to values.
Curve = Callable[[NDArray[np.float64], bool], NDArray[np.float64]]


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """One variable over time, with what is needed to label it.

    It converts to a NumPy array wherever one is expected, and is a function of time::

        voltage = result["c.v"]
        voltage.max(), voltage[-1], voltage(0.0123)
        (voltage * result["r.i"]).to("mW").mean()

    Sums, products and powers carry the unit; NumPy's functions give plain arrays.

    Attributes:
        path: The variable's path in the model, e.g. ``c.v``.
        time: Times in seconds, not decreasing, shape ``(nt,)``. An event is two equal times.
        values: Values in ``unit``, shape ``(nt,)``; SI units unless :meth:`to` was asked.
        unit: Unit text, empty if the variable has none.
        description: Description string of the variable.
        curve: The solver's own polynomial, if the run has kept it (``simulate(dense=True)``).
    """

    path: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    unit: str = ""
    description: str = ""
    curve: Curve | None = field(default=None, repr=False)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:
        """Return the values as an array."""
        if copy:
            return np.array(self.values, dtype=dtype)
        return np.asarray(self.values, dtype=dtype)

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[float]:
        return iter(self.values.tolist())

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice | NDArray[Any]) -> NDArray[np.float64]: ...
    def __getitem__(self, index: Any) -> Any:
        """Return values by position in time."""
        picked = self.values[index]
        return float(picked) if np.ndim(picked) == 0 else picked

    @overload
    def __call__(self, time: float, side: str = ...) -> float: ...
    @overload
    def __call__(
        self, time: NDArray[Any] | list[float], side: str = ...
    ) -> NDArray[np.float64]: ...
    def __call__(self, time: ArrayLike, side: str = "after") -> Any:
        """Return the value at any time.

        The solver's own polynomial gives it if the run has kept it (``simulate(dense=True)``),
        else it is linear between the stored points.

        Args:
            time: One time or an array of times, seconds.
            side: Which value is meant at an event, the one ``"before"`` or ``"after"`` it.

        Raises:
            AcausalError: ``F211`` if a time lies outside the simulated interval.
        """
        if side not in ("before", "after"):
            fail("F211", f"an event has no side {side!r}", help='write "before" or "after"')
        wanted = np.asarray(time, dtype=np.float64)
        self._need_inside(wanted)
        if self.curve is not None:
            flat = np.clip(wanted.reshape(-1), self.time[0], self.time[-1])
            result = self.curve(flat, side == "before").reshape(wanted.shape)
        elif len(self.time) == 1:
            result = np.full(wanted.shape, self.values[0])
        else:
            result = self._linear(wanted, side == "before")
        return float(result) if result.ndim == 0 else result

    def _need_inside(self, wanted: NDArray[np.float64]) -> None:
        if len(self.time) == 0:
            fail("F211", f"{self.path} has no values", help="simulate for a longer time")
        first, last = float(self.time[0]), float(self.time[-1])
        slack = 1e-12 * max(abs(first), abs(last))
        outside = ~((wanted >= first - slack) & (wanted <= last + slack))
        if np.any(outside):
            fail(
                "F211",
                f"{self.path} is not known at {float(wanted[outside].flat[0]):g} s",
                notes=[f"the simulation covers {first:g} s to {last:g} s"],
                help="ask for a time in this interval, or simulate longer",
            )

    def _linear(self, wanted: NDArray[np.float64], before: bool) -> NDArray[np.float64]:
        # The segment whose left end is the last point not after the wanted time: of two
        # equal times (an event), the second. Before an event: the mirror image.
        if before:
            left = np.searchsorted(self.time, wanted, side="left") - 1
        else:
            left = np.searchsorted(self.time, wanted, side="right") - 1
        left = np.clip(left, 0, len(self.time) - 2)
        width = self.time[left + 1] - self.time[left]
        still = 0.0 if before else 1.0
        part = np.where(width > 0, (wanted - self.time[left]) / np.where(width, width, 1.0), still)
        part = np.clip(part, 0.0, 1.0)
        # A point itself is met exactly, also where its neighbour is infinite.
        values = self.values[left] * (1.0 - part) + self.values[left + 1] * part
        values = np.where(part == 0.0, self.values[left], values)
        result: NDArray[np.float64] = np.where(part == 1.0, self.values[left + 1], values)
        return result

    def sampled(self, times: ArrayLike) -> Trajectory:
        """Return the variable at other times, for example at those of another run.

        Raises:
            AcausalError: ``F211`` if a time lies outside the simulated interval.
        """
        wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
        return Trajectory(self.path, wanted, self(wanted), self.unit, self.description, self.curve)

    def to(self, unit: str) -> Trajectory:
        """Return the variable in another unit of the same quantity.

        Raises:
            AcausalError: ``U104`` if it is no unit, ``U101`` if it is one of another quantity.

        Example:
            >>> result["c.v"].to("mV").max()
        """
        return arithmetic.converted(self, unit)

    # --- numbers taken from it; arguments that NumPy hands over (np.max(x)) have no effect

    def max(self, **_: object) -> Extreme:
        """Return the largest value, which has an attribute ``time``."""
        return measures.extreme(self, 1.0)

    def min(self, **_: object) -> Extreme:
        """Return the smallest value, which has an attribute ``time``."""
        return measures.extreme(self, -1.0)

    def mean(self, **_: object) -> float:
        """Return the mean over time (not over the points), in ``unit``."""
        return measures.mean(self)

    def rms(self) -> float:
        """Return the root of the mean square over time, in ``unit``."""
        return float(np.sqrt(measures.mean_square(self)))

    def integral(self) -> Trajectory:
        """Return the integral over time from the start on, by the trapezoidal rule."""
        name = f"integral of {self.path}"
        unit = arithmetic.known_unit(self.unit)
        whole = Trajectory(name, self.time, measures.integral(self))
        if unit is None:
            return whole
        second = Trajectory("s", self.time, np.ones(len(self.time)), "s")
        product = Trajectory(name, self.time, whole.values, self.unit) * second
        return Trajectory(name, self.time, product.values, product.unit)

    def crossings(self, level: float = 0.0, direction: int = 0) -> NDArray[np.float64]:
        """Return the times at which a level is crossed, upwards (1), downwards (-1) or both."""
        return measures.crossings(self, level, direction)

    def period(self, level: float | None = None) -> float:
        """Return the mean time between upward crossings of a level, the mean by default.

        Returns:
            Seconds; NaN if there are not two crossings.
        """
        return measures.period(self, level)

    def settle_time(self, band: float = 0.02, final: float | None = None) -> float:
        """Return the time after which the variable stays near its end.

        Args:
            band: Largest distance from the end, as a share of the largest distance there was.
            final: Where it ends, in ``unit``; the last value by default.

        Returns:
            Seconds from the first time; NaN if it does not stay there.
        """
        return measures.settle_time(self, band, final)

    def jumps(self) -> list[Jump]:
        """Return the events at which the variable jumps: time, value before, value after."""
        return measures.jumps(self)

    # --- arithmetic

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        """Let NumPy's sums and products of variables be variables; other functions give arrays."""
        sign = arithmetic.UFUNCS.get(ufunc)
        if sign is not None and method == "__call__" and not options:
            result = arithmetic.combined(sign, *inputs)
            if result is not NotImplemented:
                return result
        plain = [x.values if isinstance(x, Trajectory) else x for x in inputs]
        return getattr(ufunc, method)(*plain, **options)

    def __add__(self, other: Trajectory | float) -> Trajectory:
        return self._with("+", self, other)

    def __radd__(self, other: float) -> Trajectory:
        return self._with("+", other, self)

    def __sub__(self, other: Trajectory | float) -> Trajectory:
        return self._with("-", self, other)

    def __rsub__(self, other: float) -> Trajectory:
        return self._with("-", other, self)

    def __mul__(self, other: Trajectory | float) -> Trajectory:
        return self._with("*", self, other)

    def __rmul__(self, other: float) -> Trajectory:
        return self._with("*", other, self)

    def __truediv__(self, other: Trajectory | float) -> Trajectory:
        return self._with("/", self, other)

    def __rtruediv__(self, other: float) -> Trajectory:
        return self._with("/", other, self)

    def __pow__(self, other: Trajectory | float) -> Trajectory:
        return self._with("**", self, other)

    def __rpow__(self, other: float) -> Trajectory:
        return self._with("**", other, self)

    def __neg__(self) -> Trajectory:
        return arithmetic.negated(self)

    def __abs__(self) -> Trajectory:
        return arithmetic.absolute(self)

    def _with(self, sign: str, left: Any, right: Any) -> Trajectory:
        other = right if left is self else left
        plain = isinstance(other, np.ndarray) and other.ndim > 0
        operation = arithmetic.arrays if plain else arithmetic.combined
        result: Trajectory = operation(sign, left, right)
        return result

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        from acausal.results.display import trajectory_html

        return trajectory_html(self)

    def __repr__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        if not len(self.values):
            return f"<{self.path}{unit}: no values>"
        return (
            f"<{self.path}{unit}: {len(self.values)} values, "
            f"{np.fmin.reduce(self.values):.6g} to {np.fmax.reduce(self.values):.6g}, "
            f"{self.time[0]:g} s to {self.time[-1]:g} s>"
        )
