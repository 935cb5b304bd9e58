"""What a file says about the simulation it came from, as flat text and numbers."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping
from typing import Any

import numpy as np

from acausal.diagnostics import Diagnostic, Severity
from acausal.results.result import Ending, Event, Result
from acausal.version import __version__

#: Parameters are written into a file up to this number.
MOST_PARAMETERS = 10_000


def metadata(result: Result) -> dict[str, str]:
    """Return the metadata of a result; tables in it are JSON texts."""
    data = {
        "model": result.model_name,
        "description": result.description,
        "acausal": __version__,
        "versions": json.dumps({"python": platform.python_version(), "numpy": np.__version__}),
        "experiment": json.dumps(dict(result.experiment)),
        "states": json.dumps(list(result.states)[:MOST_PARAMETERS]),
    }
    if len(result.parameters) <= MOST_PARAMETERS:
        parameters = dict(result.parameters)
        units = {path: result.parameter_units.get(path, "") for path in parameters}
        data["parameters"] = json.dumps(parameters)
        data["parameter_units"] = json.dumps({path: unit for path, unit in units.items() if unit})
    return data | final_metadata(result)


def final_metadata(result: Result) -> dict[str, str]:
    """Return the part of the metadata that is known at the end of a run only."""
    told = [
        [d.code, d.severity.value, d.message, list(d.notes), d.help] for d in result.diagnostics
    ]
    return {
        "ending": result.ending.value,
        "statistics": json.dumps(dict(result.statistics)),
        "events": json.dumps([[event.time, event.text] for event in result.events]),
        "diagnostics": json.dumps(told),
    }


def fields(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of :class:`Result` that a file's metadata gives; unknown keys are left.

    Raises:
        ValueError: If a table in it is no JSON or an ending is unknown.
    """
    return {
        "model_name": str(data.get("model", "")),
        "description": str(data.get("description", "")),
        "states": tuple(json.loads(data.get("states", "[]"))),
        "parameters": json.loads(data.get("parameters", "{}")),
        "parameter_units": json.loads(data.get("parameter_units", "{}")),
        "events": tuple(Event(float(t), str(s)) for t, s in json.loads(data.get("events", "[]"))),
        "statistics": json.loads(data.get("statistics", "{}")),
        "experiment": json.loads(data.get("experiment", "{}")),
        "ending": Ending(data.get("ending", "complete")),
        "diagnostics": tuple(
            Diagnostic(code, message, notes=tuple(notes), help=help_, severity=Severity(severity))
            for code, severity, message, notes, help_ in json.loads(data.get("diagnostics", "[]"))
        ),
    }
