"""One variable over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from acausal.diagnostics import fail


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """One variable over time, with what is needed to label it.

    It converts to a NumPy array wherever one is expected, and is a function of time::

        voltage = result["c.v"]
        np.max(voltage), voltage[-1], voltage(0.0123)

    Attributes:
        path: The variable's path in the model, e.g. ``c.v``.
        time: Times in seconds, not decreasing, shape ``(nt,)``. An event is two equal times.
        values: Values in SI units, shape ``(nt,)``.
        unit: Unit text, empty if the variable has none.
        description: Description string of the variable.
    """

    path: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    unit: str = ""
    description: str = ""

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
    def __call__(self, time: float) -> float: ...
    @overload
    def __call__(self, time: NDArray[Any] | list[float]) -> NDArray[np.float64]: ...
    def __call__(self, time: ArrayLike) -> Any:
        """Return the value at any time, linear between the stored points.

        At an event the value after it is returned.

        Args:
            time: One time or an array of times, seconds.

        Raises:
            AcausalError: ``F211`` if a time lies outside the simulated interval.
        """
        wanted = np.asarray(time, dtype=np.float64)
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
        if len(self.time) == 1:
            result = np.full(wanted.shape, self.values[0])
        else:
            # The segment whose left end is the last point not after the wanted time: of two
            # equal times (an event), the second.
            left = np.searchsorted(self.time, wanted, side="right") - 1
            left = np.clip(left, 0, len(self.time) - 2)
            width = self.time[left + 1] - self.time[left]
            part = np.where(width > 0, (wanted - self.time[left]) / np.where(width, width, 1.0), 1)
            part = np.clip(part, 0.0, 1.0)
            result = self.values[left] * (1.0 - part) + self.values[left + 1] * part
        return float(result) if result.ndim == 0 else result

    def __repr__(self) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        if not len(self.values):
            return f"<{self.path}{unit}: no values>"
        return (
            f"<{self.path}{unit}: {len(self.values)} values, "
            f"{self.values.min():.6g} to {self.values.max():.6g}, "
            f"{self.time[0]:g} s to {self.time[-1]:g} s>"
        )
