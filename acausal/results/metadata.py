"""What a file says about the simulation it came from, as flat text and numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

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
        "ending": result.ending.value,
        "experiment": json.dumps(dict(result.experiment)),
        "statistics": json.dumps(dict(result.statistics)),
        "states": json.dumps(list(result.states)[:MOST_PARAMETERS]),
        "events": json.dumps([[event.time, event.text] for event in result.events]),
    }
    if len(result.parameters) <= MOST_PARAMETERS:
        data["parameters"] = json.dumps(dict(result.parameters))
    return data


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
        "events": tuple(Event(float(t), str(s)) for t, s in json.loads(data.get("events", "[]"))),
        "statistics": json.loads(data.get("statistics", "{}")),
        "experiment": json.loads(data.get("experiment", "{}")),
        "ending": Ending(data.get("ending", "complete")),
    }
