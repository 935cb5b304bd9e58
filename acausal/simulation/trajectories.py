"""What a run has stored, and every variable of the model computed from it when asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acausal.assembly.observe import Held, Observer
from acausal.flattening.model import Ids, Names

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Segment:
    """A part of a run with one choice of states.

    Attributes:
        observer: Computes variables from what is stored.
        times: Shape ``(nt,)``.
        y: Unknowns, shape ``(nt, n)``; without columns if only chosen variables are kept.
        yp: Derivatives, likewise.
        chosen: Values of the chosen variables, shape ``(nt, k)``, or None.
        held: Held values, None if the model has none or only chosen variables are kept.
    """

    observer: Observer
    times: Array
    y: Array
    yp: Array
    chosen: Array | None = None
    held: Held | None = None


@dataclass
class Trajectories:
    """A :class:`acausal.results.result.VariableSource` over segments.

    Attributes:
        names: Paths of the variables.
        derivative: Id of each variable's derivative or -1, those of index reduction included.
        representative, sign: Who stands for each declared variable, and how.
        chosen: Ids that were kept, or None if everything was.
        segments: The parts, in order of time.
    """

    names: Names
    derivative: Ids
    representative: Ids
    sign: NDArray[np.int8]
    chosen: Ids | None = None
    segments: list[Segment] = field(default_factory=list)

    @property
    def times(self) -> Array:
        """All stored times."""
        parts = [s.times for s in self.segments]
        return np.concatenate(parts) if parts else np.zeros(0)

    def paths(self) -> Sequence[str]:
        """Return the paths of all variables that were kept."""
        if self.chosen is None:
            return self.names.all_variables()
        return [self.names.variable(int(i)) for i in self.chosen]

    def find(self, pattern: str) -> list[str]:
        """Return the paths that match a pattern."""
        found = self.names.find_variables(pattern)
        if self.chosen is not None:
            kept = set(self.chosen.tolist())
            found = [(path, i) for path, i in found if i in kept]
        return [path for path, _ in found]

    def id_of(self, path: str) -> int:
        """Return the id of a variable.

        Raises:
            KeyError: If there is no such variable.
        """
        found = self.names.find_variables(path)
        if len(found) == 1:
            return found[0][1]
        if path.startswith("der(") and path.endswith(")"):
            inside = self.id_of(path[4:-1])
            if self.sign[inside] > 0:
                further = int(self.derivative[self.representative[inside]])
                if further >= 0:
                    return further
        raise KeyError(path)

    def values(self, path: str) -> Array:
        """Return a variable's values, SI units, shape ``(nt,)``.

        Raises:
            KeyError: If there is no such variable, or it was not kept.
        """
        return self.values_of([self.id_of(path)])[:, 0]

    def values_of(self, ids: Sequence[int]) -> Array:
        """Return the values of variables by id, shape ``(nt, len(ids))``.

        Raises:
            KeyError: If one was not kept.
        """
        parts = []
        for segment in self.segments:
            if self.chosen is None:
                parts.append(
                    segment.observer.values(ids, segment.times, segment.y, segment.yp, segment.held)
                )
            else:
                places = np.searchsorted(self.chosen, ids)
                bad = (places >= len(self.chosen)) | (
                    self.chosen[np.minimum(places, len(self.chosen) - 1)] != np.asarray(ids)
                )
                if bad.any():
                    raise KeyError(self.names.variable(int(np.asarray(ids)[bad][0])))
                assert segment.chosen is not None
                parts.append(segment.chosen[:, places])
        return np.concatenate(parts) if parts else np.zeros((0, len(ids)))

    def many(self, paths: Sequence[str]) -> Array:
        """Return the values of several variables at once, shape ``(nt, len(paths))``."""
        return self.values_of([self.id_of(p) for p in paths])

    def unit(self, path: str) -> str:
        """Return the unit text of a variable."""
        try:
            found = self.id_of(path)
        except KeyError:
            return ""
        return self.names.unit(found) if found < len(self.representative) else ""

    def description(self, path: str) -> str:
        """Return the description string of a variable."""
        try:
            found = self.id_of(path)
        except KeyError:
            return ""
        return self.names.description(found) if found < len(self.representative) else ""

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths to a misspelt one."""
        return self.names.suggestions(path)
