"""A folder that a sweep writes while it runs, and from which it goes on after an interruption.

``study.json`` says what is being run; every ``part-N.parquet`` holds the outcomes of some points,
one row for each stored time, what else is known of them as JSON in its metadata. Files appear
whole or not at all.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from acausal.diagnostics import Diagnostic, fail
from acausal.results.files import needs
from acausal.results.result import Ending
from acausal.runs.job import Outcome

FORMAT = 1


class Store:
    """The folder of one sweep."""

    def __init__(self, folder: str | Path, study: dict[str, Any], paths: Sequence[str]) -> None:
        """Open or create a folder.

        Args:
            folder: Where.
            study: What is being run, in terms of JSON.
            paths: Stored variables.

        Raises:
            AcausalError: ``F140`` if the folder holds another study or cannot be written.
        """
        self.folder = Path(folder)
        self._paths = list(paths)
        text = json.dumps({"format": FORMAT, **study}, sort_keys=True, indent=1)
        file = self.folder / "study.json"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            if file.is_file():
                if file.read_text(encoding="utf-8") != text:
                    fail("F140", f"{folder} holds the results of another study",
                         help="give another folder, or delete this one")  # fmt: skip
            else:
                _write(file, text.encode())
        except OSError as error:
            fail("F140", f"{folder} cannot be written", notes=[str(error)],
                 help="give another folder")  # fmt: skip
        self._next = 1 + max((int(p.stem[5:]) for p in self._parts()), default=-1)

    def _parts(self) -> list[Path]:
        return sorted(self.folder.glob("part-*.parquet"))

    def outcomes(self) -> list[Outcome]:
        """Return what is stored already.

        Raises:
            AcausalError: ``F140`` for a file that cannot be read.
        """
        _, parquet = _libraries()
        found: list[Outcome] = []
        for part in self._parts():
            try:
                table = parquet.read_table(str(part))
                about = json.loads((table.schema.metadata or {})[b"about"])
            except (OSError, ValueError, KeyError) as error:
                fail("F140", f"{part} cannot be read", notes=[str(error)],
                     help="delete this file; its points are run again")  # fmt: skip
            columns = [table.column(name).to_numpy() for name in ["time", *self._paths]]
            first = 0
            for item in about:
                rows = slice(first, first := first + item["rows"])
                found.append(_outcome(item, [c[rows] for c in columns]))
        return found

    def add(self, outcomes: Sequence[Outcome]) -> None:
        """Write outcomes.

        Raises:
            AcausalError: ``F140`` if they cannot be written.
        """
        pyarrow, parquet = _libraries()
        schema = pyarrow.schema(
            [pyarrow.field(name, pyarrow.float64()) for name in ["time", *self._paths]],
            metadata={"about": json.dumps([_about(o) for o in outcomes])},
        )
        times = np.concatenate([o.times for o in outcomes])
        full = [o.values for o in outcomes if len(o.times)]
        values = np.concatenate(full) if full else np.zeros((0, len(self._paths)))
        columns = [times, *(np.ascontiguousarray(values[:, k]) for k in range(len(self._paths)))]
        buffer = pyarrow.BufferOutputStream()
        parquet.write_table(pyarrow.table(columns, schema=schema), buffer)
        try:
            _write(self.folder / f"part-{self._next:06d}.parquet", buffer.getvalue().to_pybytes())
        except OSError as error:
            fail("F140", f"{self.folder} cannot be written", notes=[str(error)],
                 help="make room, and start the sweep again: it goes on")  # fmt: skip
        self._next += 1


def digest(*parts: object) -> str:
    """Return a short name of what decides about results."""
    return blake2b(repr(parts).encode(), digest_size=12).hexdigest()


def _about(outcome: Outcome) -> dict[str, Any]:
    about = dict(outcome.about)
    if about:
        about["ending"] = about["ending"].value
    error = outcome.error
    return {
        "number": outcome.number,
        "rows": len(outcome.times),
        "about": about,
        "error": None if error is None else [error.code, error.message, error.help],
    }


def _outcome(item: dict[str, Any], columns: list[Any]) -> Outcome:
    about = item["about"]
    if about:
        about["ending"] = Ending(about["ending"])
    error = None
    if item["error"] is not None:
        code, message, advice = item["error"]
        error = Diagnostic(code, message, help=advice)
    values = np.column_stack(columns[1:]) if len(columns) > 1 else np.zeros((item["rows"], 0))
    return Outcome(item["number"], columns[0], values, about, error)


def _write(path: Path, data: bytes) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_bytes(data)
    temporary.replace(path)


def _libraries() -> tuple[Any, Any]:
    with needs("pyarrow", "stores of sweeps"):
        import pyarrow
        from pyarrow import parquet
    return pyarrow, parquet
