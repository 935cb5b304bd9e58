"""Which components of the list are in the library, tested, described, and drawn.

``python -m tests.coverage [--missing] [--tier A] [PACKAGE...]`` prints a table and ends with 1 if
something of tier A is missing. The lists are ``tests/data/coverage/*.csv``: tier, section, name in
the Modelica Standard Library (or where the name comes from), our class.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from acausal.modeling.classes import Builtin, ClassDef
from acausal.modeling.library import Root, standard_library
from acausal.modeling.listing import declared, unit_of
from acausal.modeling.load import library_class
from acausal.reference.symbols import symbol
from tests.library_use import used_in_tests

LISTS = Path(__file__).parent / "data" / "coverage"

#: Lists of which every component of tier A is there and tested. ``tests/library/test_coverage.py``
#: keeps it that way.
FINISHED = (
    "blocks",
    "electrical",
    "hydraulic",
    "magnetic",
    "multiport",
    "planar",
    "pneumatic",
    "rotational",
    "thermal",
    "translational",
    "vehicle",
)

#: Pure numbers by nature: signals have the unit that their source gives them.
WITHOUT_UNITS = ("blocks",)


@dataclass(frozen=True)
class Row:
    """One component of a list and what there is of it."""

    list: str
    tier: str
    section: str
    name: str
    path: str
    present: bool
    tested: bool
    described: bool
    units: bool
    icon: bool

    @property
    def complete(self) -> bool:
        """Whether nothing is missing."""
        return all((self.present, self.tested, self.described, self.units, self.icon))


MARKS = ("present", "tested", "described", "units", "icon")


def coverage(root: Root | None = None) -> list[Row]:
    """Return all components of all lists."""
    root = root or standard_library()
    used = used_in_tests(root)
    rows = []
    for file in sorted(LISTS.glob("*.csv")):
        with file.open(encoding="utf-8", newline="") as lines:
            for entry in csv.DictReader(lines):
                found = library_class(entry["path"], root)
                here = isinstance(found, ClassDef)
                rows.append(
                    Row(
                        file.stem,
                        entry["tier"],
                        entry["section"],
                        entry["name"],
                        entry["path"],
                        here,
                        here and entry["path"] in used,
                        isinstance(found, ClassDef) and not undescribed(found),
                        isinstance(found, ClassDef) and not without_unit(found),
                        isinstance(found, ClassDef) and _drawn(found),
                    )
                )
    return rows


def undescribed(definition: ClassDef) -> list[str]:
    """Return what of a class has no description: the class (empty text) and its components.

    What ``outer`` components are, their ``inner`` ones say.
    """
    missing = [] if definition.tree.description else [""]
    for component in definition.tree.components:
        if component.public and not component.description and "outer" not in component.prefixes:
            missing.append(component.name)
    return missing


def without_unit(definition: ClassDef) -> list[str]:
    """Return the public components that carry a number with a unit and do not say which.

    A plain ``Real`` is a pure number; it may not get a value with a unit.
    """
    missing = []
    for found in declared(definition):
        component = found.component
        unit, simple = unit_of(component, found.type_class)
        if not simple or unit or not component.public:
            continue
        if found.owner.full_name.split(".")[0] in WITHOUT_UNITS:
            continue
        value = component.value
        real = isinstance(found.type_class, Builtin) and found.type_class.name == "Real"
        if real and getattr(value, "unit", None) is not None:
            missing.append(component.name)
    return missing


def _drawn(definition: ClassDef) -> bool:
    return definition.kind in ("function", "record", "type") or symbol(definition).drawn


def table(rows: Sequence[Row], missing: bool = False) -> list[str]:
    """Return the rows as lines of text, those that lack something only if ``missing``."""
    shown = [r for r in rows if not missing or not r.complete]
    width = max((len(r.path) for r in shown), default=10)
    lines = []
    heading = ""
    for row in shown:
        if f"{row.list}: {row.section}" != heading:
            heading = f"{row.list}: {row.section}"
            lines += ["", heading] if lines else [heading]
        marks = " ".join((m if getattr(row, m) else "-").ljust(len(m)) for m in MARKS)
        lines.append(f"  {row.tier}  {row.path.ljust(width)}  {marks}".rstrip())
    return lines


def totals(rows: Sequence[Row]) -> list[str]:
    """Return counts for every list and tier."""
    lines = [f"{'list':<16}{'tier':>4}{'of':>6}" + "".join(f"{m:>11}" for m in MARKS)]
    keys = [(r.list, r.tier) for r in rows]
    groups = [*sorted(dict.fromkeys(keys)), *(("all", t) for t in sorted({r.tier for r in rows}))]
    for name, tier in groups:
        chosen = [r for r in rows if r.tier == tier and name in (r.list, "all")]
        counts = "".join(f"{sum(getattr(r, m) for r in chosen):>11}" for m in MARKS)
        lines.append(f"{name:<16}{tier:>4}{len(chosen):>6}{counts}")
    return lines


def main(arguments: list[str] | None = None) -> int:
    """Print the table; return 1 if tier A is incomplete."""
    parser = argparse.ArgumentParser(prog="python -m tests.coverage", description=__doc__)
    parser.add_argument("lists", nargs="*", metavar="LIST", help="electrical, hydraulic, ...")
    parser.add_argument("--tier", action="append", choices="ABC", help="A if not said; repeatable")
    parser.add_argument("--missing", action="store_true", help="only what lacks something")
    options = parser.parse_args(arguments)
    rows = coverage()
    if options.lists:
        rows = [r for r in rows if r.list in options.lists]
    tiers = options.tier or ["A"]
    print("\n".join(table([r for r in rows if r.tier in tiers], options.missing)))
    print("\n" + "\n".join(totals(rows)))
    return int(not all(r.present and r.tested for r in rows if r.tier == "A"))


if __name__ == "__main__":
    sys.exit(main())
