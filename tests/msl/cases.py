"""The cases of the Modelica Standard Library: which there are, and how close we come to them."""

from __future__ import annotations

import csv
import gzip
import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from acausal import compile_file
from acausal.diagnostics import AcausalError
from tests.msl.tube import share

HERE = Path(__file__).parent
DATA = HERE.parent / "data" / "msl"

#: All cases with the signals that their references have.
SIGNALS: dict[str, list[str]] = json.loads((DATA / "_cases.json").read_text())

# The tool that made these references took no notice of the events: it has no samples at the jumps,
# so its peaks are cut off. Ours are compared where it has samples.
NO_EVENTS_IN_REFERENCE = {"Electrical.Analog.OpAmps.Multivibrator"}

#: Why a case is not compared, or known not to stay in the tube.
REASONS: dict[str, str] = {
    "Electrical.Analog.CompareTransformers": "no published reference; the tests integrate its "
    "equations independently",
}


@dataclass(frozen=True)
class Comparison:
    """How a case compares with its reference.

    Attributes:
        case: Its name.
        signals: Share of the tube that each signal uses: 0 on the reference, 1 at the border,
            more outside.
        seconds: Wall time of compiling and simulating.
        reason: Why there is nothing to compare; empty if there is.
    """

    case: str
    signals: dict[str, float]
    seconds: float = 0.0
    reason: str = ""

    @property
    def worst(self) -> tuple[str, float]:
        """The signal that uses the largest share of its tube."""
        if not self.signals:
            return "", float("nan")
        return max(self.signals.items(), key=lambda item: item[1])

    @property
    def inside(self) -> bool:
        """Whether all signals stay inside of the tube."""
        return bool(self.signals) and self.worst[1] <= 1.0


def description(case: str) -> dict[str, Any]:
    """Return model, experiment, signals, and what is known of the tube."""
    data: dict[str, Any] = json.loads((DATA / f"{case}.json").read_text())
    return data


def has_reference(case: str) -> bool:
    """Return whether the whole reference trajectory is there."""
    return (DATA / f"{case}.csv.gz").is_file()


def read_reference(case: str) -> dict[str, np.ndarray]:
    """Return the reference by signal, its times under ``time``."""
    with gzip.open(DATA / f"{case}.csv.gz", "rt") as file:
        rows = list(csv.reader(file))
    table = np.array(rows[1:], dtype=float)
    return {name if k else "time": table[:, k] for k, name in enumerate(rows[0])}


def simulate(case: str) -> Any:
    """Simulate a case as its description says."""
    about = description(case)
    run = about["experiment"]
    compiled = compile_file(HERE / f"{case}.acm", model=about["model"])
    return compiled.simulate(
        stop_time=run["stop"],
        interval=run["interval"],
        tolerance=min(run["solver_tolerance"], 1e-6),
    )


def shares(case: str, result: Any) -> dict[str, float]:
    """Return the share of its tube that each signal of a result uses."""
    about = description(case)
    if not has_reference(case):  # only some samples of the tube are known
        known = {}
        for signal, bounds in about["tube"].items():
            values = np.interp(about["times"], result.times, result[signal].values)
            low, high = np.array(bounds).T
            known[signal] = float(np.max(np.abs(values - (low + high) / 2) / ((high - low) / 2)))
        return known
    reference = read_reference(case)
    if result.times[-1] < reference["time"][-1] * (1 - 1e-9):
        raise AssertionError(f"the run ends at {result.times[-1]:g} s")
    compared = np.ones(len(result.times), np.bool_)
    if case in NO_EVENTS_IN_REFERENCE:
        compared = np.isin(np.round(result.times, 9), np.round(reference["time"], 9))
    times = np.asarray(result.times)[compared]
    found = {}
    for signal in about["signals"]:
        values = np.asarray(result[signal].values)[compared]
        found[signal] = share(reference["time"], reference[signal], times, values)
    return found


def compare(case: str) -> Comparison:
    """Simulate a case and compare it; whatever goes wrong is the reason."""
    if not (HERE / f"{case}.acm").is_file():
        return Comparison(case, {}, reason=REASONS.get(case, "not translated"))
    if not has_reference(case) and not description(case)["tube"]:
        return Comparison(case, {}, reason=REASONS.get(case, "no published reference"))
    begin = time.perf_counter()
    try:
        result = simulate(case)
        seconds = time.perf_counter() - begin
        return Comparison(case, shares(case, result), seconds)
    except (AcausalError, AssertionError) as error:
        text = str(error).splitlines()[0]
        return Comparison(case, {}, time.perf_counter() - begin, REASONS.get(case, text))
