"""What events cost, beside hand-written loops around IDA and, for circuits, beside ngspice."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import spice
from benchmarks.processes import MODELS, FailedError, Worker
from benchmarks.reference_program import EVENTS, ReferenceProgram, build
from benchmarks.table import Column, Table

RELATIVE, ABSOLUTE = 1e-6, 1e-9
ACCURATE = (1e-10, 1e-13)
SPICE_TOLERANCE = 1e-5
FILE = MODELS / "events.acm"
#: Most seconds beyond the steps: of an event that has to be found, and of one known beforehand.
STATE_EVENT, TIME_EVENT = 50e-6, 20e-6
RELATIONS = 10_000


@dataclass(frozen=True)
class Case:
    """A model, and the same problem of the C program.

    Attributes:
        label: Name in the table.
        model: Name in ``models/events.acm``.
        reference: Name of the problem in the C program.
        stop: End, seconds; a tenth of it in a quick run.
        compared: A variable that is compared at the end.
        place: Its place among the unknowns of the C program.
        scale: Its largest value.
        bar: Most seconds that an event may take beyond the steps.
        circuit, quantity, factor: The circuit in ngspice, what is the variable there and by which
            factor; empty if there is none.
        step: Longest step there, seconds.
    """

    label: str
    model: str
    reference: str
    stop: float
    compared: str
    place: int
    scale: float
    bar: float
    circuit: str = ""
    quantity: str = ""
    factor: float = 1.0
    step: float = 1e-3


CASES = (
    Case("bouncing ball, 10 variables", "Ball", "ball", 900, "h", 0, 1, STATE_EVENT),
    Case("half-wave rectifier", "HalfWave", "half_wave", 20, "c.v", 0, 10, STATE_EVENT,
         "half_wave", "v(p)"),
    Case("ideal-diode bridge", "Bridge", "bridge", 10, "c.v", 0, 10, STATE_EVENT,
         "bridge", "v(p)"),
    Case("stick and slip", "StickSlip", "stick_slip", 500, "x", 0, 0.12, STATE_EVENT),
    Case("pulse width modulation", "Pwm", "pwm", 5, "i", 0, 12, TIME_EVENT,
         "pwm", "v(a)", 0.5),
    Case("buck converter, 50 kHz", "Buck", "buck", 1, "c.v", 1, 24, TIME_EVENT,
         "buck", "v(p)"),
)  # fmt: skip

COLUMNS = (
    Column("problem", "problem"),
    Column("events", "events", "n"),
    Column("time", "time", "s"),
    Column("reference", "C", "s"),
    Column("spice", "ngspice", "s"),
    Column("per_event", "per event", "s"),
    Column("reference_per_event", "C", "s"),
    Column("beyond", "beyond the steps", "s"),
    Column("steps", "steps", "n"),
    Column("reference_steps", "C", "n"),
    Column("spice_steps", "ngspice", "n"),
    Column("error", "error", "e"),
    Column("reference_error", "C", "e"),
    Column("spice_error", "ngspice", "e"),
)

RELATION_COLUMNS = (
    Column("problem", "relations"),
    Column("time", "with", "s"),
    Column("plain", "without", "s"),
    Column("ratio", "ratio per step", "x", 2.0),
    Column("steps", "steps with", "n"),
    Column("steps_plain", "without", "n"),
    Column("reference", "C, with", "s"),
    Column("reference_plain", "C, without", "s"),
    Column("reference_ratio", "ratio per step", "x"),
)


def measure(quick: bool, say: Callable[[str], None]) -> list[Table]:
    """Return the table of events and that of relations without events."""
    events = Table("events", "Events", COLUMNS)
    relations = Table("events", "Relations that do not change", RELATION_COLUMNS)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        try:
            program = build(folder, EVENTS)
        except FailedError as failure:
            events.notes.append(f"Skipped: {failure}.")
            return [events]
        have = spice.ngspice()
        events.notes += [
            f"{program.description}. {have or 'ngspice is not installed'}. Tolerance "
            f"{RELATIVE:g}, of ngspice {SPICE_TOLERANCE:g}; minima over runs in turn.",
            "Processor seconds after the consistent start, stored points included. Beyond the "
            "steps: the time without our number of steps at the C program's time per step (which "
            "has its restarts and events in it), per event. Error: end value against C at "
            f"tolerance {ACCURATE[0]:g}, relative to the largest value.",
        ]  # fmt: skip
        for case in CASES:
            say(case.label)
            try:
                events.rows.append(_row(case, program, folder, quick, have is not None))
            except FailedError as failure:
                events.rows.append({"problem": case.label, "failed": str(failure)})
        say("relations")
        try:
            relations.rows.append(_relations(program, RELATIONS // 10 if quick else RELATIONS))
        except FailedError as failure:
            relations.rows.append({"problem": str(RELATIONS), "failed": str(failure)})
    return [events, relations]


def _run(worker: Worker, stop: float) -> dict[str, Any]:
    return worker.ask(action="simulate", repeats=1, points=2, tolerance=RELATIVE, stop=stop)


def _best(figures: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the fastest run; its ``cpu`` is without the search for the start.

    That search is measured by the clock, which other programs disturb; so its smallest time counts.
    """
    best = min(figures, key=lambda f: float(f["cpu"]))
    return {**best, "cpu": best["cpu"] - min(float(f["start_time"]) for f in figures)}


def _row(
    case: Case, program: ReferenceProgram, folder: Path, quick: bool, have_spice: bool
) -> dict[str, Any]:
    stop = case.stop / 10 if quick else case.stop
    end = folder / "end.bin"
    ours: list[dict[str, Any]] = []
    theirs: list[dict[str, Any]] = []
    with Worker() as worker:
        worker.ask(action="compile", file=str(FILE), model=case.model, parameters={})
        for _ in range(3):
            theirs.append(
                program.solve_events(case.reference, 1, stop, (RELATIVE, ABSOLUTE), end_file=end)
            )
            ours.append(_run(worker, stop))
        (final,) = worker.ask(action="final", paths=[case.compared])["values"]
    # The first of these doubles is the number of events.
    reference_final = float(np.fromfile(end)[1 + case.place])
    program.solve_events(case.reference, 1, stop, ACCURATE, end_file=end)
    accurate = float(np.fromfile(end)[1 + case.place])
    mine = _best(ours)
    reference = min(theirs, key=lambda f: f["cpu"])
    steps = mine["steps"] * reference["cpu"] / reference["steps"]
    events = max(1, mine["events"])
    row = {
        "problem": case.label,
        "events": mine["events"],
        "time": mine["cpu"],
        "reference": reference["cpu"],
        "per_event": mine["cpu"] / events,
        "reference_per_event": reference["cpu"] / max(1, reference["events"]),
        "beyond": (mine["cpu"] - steps) / events,
        "bars": {"beyond": case.bar},
        "steps": mine["steps"],
        "reference_steps": reference["steps"],
        "error": abs(final - accurate) / case.scale,
        "reference_error": abs(reference_final - accurate) / case.scale,
        "ours": mine,
        "c": reference,
    }
    if case.circuit and have_spice:
        found = spice.solve(case.circuit, case.quantity, stop, case.step, SPICE_TOLERANCE, folder)
        row |= {
            "spice": found["cpu"],
            "spice_steps": found["points"],
            "spice_error": abs(case.factor * found["final"] - accurate) / case.scale,
        }
    return row


def _relations(program: ReferenceProgram, count: int) -> dict[str, Any]:
    stop = 0.1
    runs: dict[bool, list[dict[str, Any]]] = {True: [], False: []}
    references: dict[bool, list[dict[str, Any]]] = {True: [], False: []}
    with Worker() as clamped, Worker() as plain:
        workers = {True: clamped, False: plain}
        for present, worker in workers.items():
            parameters = {"N": count, "clamped": present}
            worker.ask(action="compile", file=str(FILE), model="Array", parameters=parameters)
        for _ in range(5):
            for present, worker in workers.items():
                runs[present].append(_run(worker, stop))
                references[present].append(
                    program.solve_events("array", 1, stop, (RELATIVE, ABSOLUTE), count, present)
                )
    ours = {present: _best(figures) for present, figures in runs.items()}
    theirs = {k: min(figures, key=lambda f: f["cpu"]) for k, figures in references.items()}

    def ratio(figures: dict[bool, dict[str, Any]]) -> float:
        per_step = {k: f["cpu"] / f["steps"] for k, f in figures.items()}
        return float(per_step[True] / per_step[False])

    return {
        "problem": str(count),
        "time": ours[True]["cpu"],
        "plain": ours[False]["cpu"],
        "ratio": ratio(ours),
        "steps": ours[True]["steps"],
        "steps_plain": ours[False]["steps"],
        "reference": theirs[True]["cpu"],
        "reference_plain": theirs[False]["cpu"],
        "reference_ratio": ratio(theirs),
    }
