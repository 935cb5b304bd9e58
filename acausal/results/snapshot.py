"""Where a run stood: all that it takes to go on from there."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import fail

Array = NDArray[np.float64]

#: Version of the file format.
FORMAT: Final = 1
_PREFIX: Final = "memory."


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A point of a run, with what its events have left behind.

    A run that goes on from it restarts the integrator, so that its steps differ from those of an
    uninterrupted run; the trajectory is the same within the tolerance.

    Attributes:
        model_name: Name of the model.
        time: Seconds.
        states: Ids of the states, shape ``(n,)``.
        values: Values of all variables and derivatives, SI units, shape ``(N,)``.
        parameters: Parameters and held values, shape ``(p,)``.
        memory: What relations, samples, delays and impacts remember, by name.

    Example:
        >>> first = compiled.simulate(stop_time=1.0)
        >>> second = compiled.simulate(continue_from=first.end, stop_time=2.0)
    """

    model_name: str
    time: float
    states: NDArray[np.int64]
    values: Array
    parameters: Array
    memory: Mapping[str, Array] = field(default_factory=dict)

    def save(self, path: str | Path) -> None:
        """Write it to a file, NumPy's ``.npz``.

        Raises:
            AcausalError: ``F130`` if it cannot be written.
        """
        about = json.dumps({"format": FORMAT, "model": self.model_name, "time": self.time})
        arrays: dict[str, NDArray[np.generic]] = {
            "about": np.array(about),
            "states": self.states,
            "values": self.values,
            "parameters": self.parameters,
            **{_PREFIX + name: array for name, array in self.memory.items()},
        }
        try:
            with Path(path).open("wb") as file:
                np.savez_compressed(file, allow_pickle=False, **arrays)
        except OSError as error:
            fail("F130", f"{path} cannot be written", notes=[str(error.strerror or error)],
                 help="choose another place")  # fmt: skip


def read_snapshot(path: str | Path) -> Snapshot:
    """Read a snapshot that :meth:`Snapshot.save` has written.

    Raises:
        AcausalError: ``F131`` if it cannot be read or is something else.
    """
    try:
        with np.load(path, allow_pickle=False) as found:
            about = json.loads(str(found["about"]))
            if about["format"] != FORMAT:
                raise ValueError(f"format {about['format']}")
            return Snapshot(
                str(about["model"]),
                float(about["time"]),
                found["states"],
                found["values"],
                found["parameters"],
                {n.removeprefix(_PREFIX): found[n] for n in found if n.startswith(_PREFIX)},
            )
    except (OSError, ValueError, KeyError, EOFError) as error:
        fail("F131", f"{path} is no snapshot that can be read", notes=[str(error)],
             help="give a file that Snapshot.save has written")  # fmt: skip
