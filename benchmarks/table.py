"""Tables of measurements: what is printed, and what goes into the JSON file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

#: Where a value misses its bar.
MISSED = "!"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        key: Key of its values in the rows.
        title: Heading.
        form: ``s`` seconds, ``x`` a ratio, ``n`` a count, ``e`` an error, ``MB``, or ``text``.
        bar: Largest value that is good enough, None if nothing is asked.
    """

    key: str
    title: str
    form: str = "text"
    bar: float | None = None

    def text(self, value: Any) -> str:
        """Return a value as a reader wants it."""
        if value is None:
            return "-"
        if self.form == "text":
            return str(value)
        if self.form == "n":
            return f"{int(value)}"
        if self.form == "s":
            return seconds(float(value))
        if self.form == "x":
            return f"{float(value):.2f}"
        if self.form == "MB":
            return f"{float(value) / 1e6:.0f} MB"
        return f"{float(value):.1e}"


def seconds(value: float) -> str:
    """Return a duration with three digits and a unit."""
    if value >= 1.0:
        return f"{value:.3g} s"
    return f"{value * 1e3:.3g} ms" if value >= 1e-3 else f"{value * 1e6:.3g} us"


@dataclass
class Table:
    """One benchmark's rows.

    Attributes:
        name: Name for ``--only``.
        title: Heading.
        columns: What the rows hold, in order.
        rows: Values by column key; a key ``bars`` may hold bars of this row by column key.
        notes: Lines below the table.
    """

    name: str
    title: str
    columns: Sequence[Column]
    rows: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def bar(self, row: Mapping[str, Any], column: Column) -> float | None:
        """Return the largest good value of a cell."""
        bars: Mapping[str, float | None] = row.get("bars", {})
        return bars.get(column.key, column.bar)

    def missed(self, row: Mapping[str, Any], column: Column) -> bool:
        """Return whether a cell is above its bar."""
        bar, value = self.bar(row, column), row.get(column.key)
        return bar is not None and value is not None and not float(value) <= bar

    def misses(self) -> Iterator[str]:
        """Yield a line for each cell above its bar, and for each row that failed."""
        for row in self.rows:
            label = row[self.columns[0].key]
            if row.get("failed"):
                yield f"{self.name}: {label}: {row['failed']}"
            for column in self.columns:
                if self.missed(row, column):
                    bar = column.text(self.bar(row, column))
                    value = column.text(row[column.key])
                    yield f"{self.name}: {label}: {column.title} {value}, asked for {bar}"

    def lines(self) -> list[str]:
        """Return the table as aligned text, in Markdown."""
        cells = [[c.title for c in self.columns]]
        for row in self.rows:
            line = []
            for column in self.columns:
                text = column.text(row.get(column.key))
                bar = self.bar(row, column)
                if bar is not None and row.get(column.key) is not None:
                    sign = MISSED if self.missed(row, column) else "<="
                    text += f" {sign} {column.text(bar)}" if sign == "<=" else f" {sign}"
                line.append(text)
            cells.append(line)
        widths = [max(len(line[k]) for line in cells) for k in range(len(self.columns))]
        numeric = [c.form != "text" for c in self.columns]

        def joined(line: Sequence[str]) -> str:
            pairs = zip(line, widths, numeric, strict=True)
            parts = [cell.rjust(w) if right else cell.ljust(w) for cell, w, right in pairs]
            return "| " + " | ".join(parts) + " |"

        rule = [
            "-" * (w - 1) + (":" if right else "-")
            for w, right in zip(widths, numeric, strict=True)
        ]
        failures = [
            f"{r[self.columns[0].key]}: {r['failed']}" for r in self.rows if r.get("failed")
        ]
        return [
            f"## {self.title}",
            "",
            joined(cells[0]),
            joined(rule),
            *(joined(line) for line in cells[1:]),
            *([""] if self.notes or failures else []),
            *failures,
            *self.notes,
        ]

    def data(self) -> dict[str, Any]:
        """Return the table for the JSON file, times in seconds, sizes in bytes."""
        return {"name": self.name, "title": self.title, "rows": self.rows, "notes": self.notes}
