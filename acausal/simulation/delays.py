"""Delayed values during a run: histories, and jumps that come back after the delay.

The values of a delayed expression at the accepted steps are its history, which the native
functions read (:mod:`acausal.codegen.delays`). Before the start it is constant. A jump of the
expression at an event is a jump of the delayed value one delay later, and so an event in time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.problem import KernelCall
from acausal.codegen.delays import DelayTable
from acausal.codegen.kernels import Kernel
from acausal.codegen.sequence import NativeSequence
from acausal.diagnostics import fail
from acausal.elimination.families import variable_slots
from acausal.expressions.nodes import TIME
from acausal.expressions.traverse import depends_on
from acausal.flattening.model import Hybrid, Names
from acausal.initialization.texts import member_text

Array = NDArray[np.float64]
Call = tuple[Kernel, NDArray[np.int32], NDArray[np.int32]]

#: A change of more than this share of the values is a jump.
JUMP = 1e-9


def moving(hybrid: Hybrid) -> bool:
    """Tell whether delayed expressions, or delays, change between events."""
    return any(
        bool(variable_slots(f)) or depends_on(f.template, TIME)
        for f in (*hybrid.delays, *hybrid.delay_times)
    )


def refuse_zero_delays(hybrid: Hybrid, names: Names) -> None:
    """Refuse delays of zero seconds of values that move: no step would be short enough.

    Raises:
        AcausalError: ``E025``.
    """
    for family in hybrid.delays if moving(hybrid) else ():
        none = np.flatnonzero(hybrid.delay_maxima[family.rows] <= 0.0)
        if len(none):
            text, span = member_text(family, int(none[0]), names)
            fail("E025", "a delay of a value that moves is 0 s", span, label=text,
                 help="give a time above zero, or use the value itself")  # fmt: skip


class Delays:
    """The delayed values of one work vector.

    Attributes:
        table: Their histories.
        moving: Some change between events; otherwise histories only grow at events.
    """

    def __init__(
        self, hybrid: Hybrid, w: Array, first: int, values: Sequence[Call], times: Sequence[Call]
    ) -> None:
        """Build the table.

        Args:
            hybrid: What happens at events.
            w: Work vector.
            first: Position of the first held value in it.
            values: Kernel calls of the delayed expressions, by number of the delay.
            times: Kernel calls of the delays.
        """
        nothing = np.zeros((0, 0), np.int32)
        self.table = DelayTable(
            (first + hybrid.delay_places).astype(np.int32),
            hybrid.delay_maxima,
            [KernelCall(kernel, index, target, nothing) for kernel, index, target in times],
        )
        self.moving = moving(hybrid)
        self._w = w
        self._places = first + hybrid.delay_places
        self._values: Array = np.zeros(len(hybrid.delay_places))
        self._sequence = NativeSequence(values, w, self._values)

    @property
    def shortest(self) -> float:
        """The shortest delay now, seconds: no step may be longer."""
        return float(self.table.delays.min())

    def present(self) -> Array:
        """Return the delayed expressions as they are now, a view, shape ``(d,)``."""
        self._sequence.run()
        return self._values

    def begin(self) -> None:
        """Let delayed values be what the expressions are at the first instant."""
        self._w[self._places] = self.present()

    def show(self, time: float, *, right: bool = False) -> None:
        """Write the delayed values at a time to the work vector.

        Args:
            time: Seconds.
            right: Those after a jump at this time.
        """
        self.table.right = right
        self.table.evaluate(time, self._w)

    def step(self, time: float) -> None:
        """Add an accepted step, whose values stand in the work vector, to the histories."""
        self.show(time)
        self.table.append(time, self.present())

    def jump(self, time: float, before: Array) -> Array:
        """Add what an event has changed; return the times of the jumps to come.

        Args:
            time: Seconds.
            before: The delayed expressions before the event, shape ``(d,)``.
        """
        after = self.present()
        size = np.maximum(np.abs(before), np.abs(after))
        jumped = np.abs(after - before) > JUMP * size
        if not jumped.any():
            return np.zeros(0)
        if self.table.last_time < time:
            self.table.append(time, before)
        self.table.append(time, after)
        times: Array = np.unique(time + self.table.delays[jumped])
        return times
