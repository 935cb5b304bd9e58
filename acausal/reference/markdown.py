"""The index of the library as a page of the manual.

``python -m acausal.reference.markdown > docs/reference.md`` writes it.
"""

from __future__ import annotations

from acausal.modeling.classes import ClassDef
from acausal.modeling.library import Root, standard_library
from acausal.reference.catalogue import Package, packages

_HEAD = """\
# Component library

All classes of the library by package. `acausal reference` writes a page for each package with
symbols, ports, parameters, equations and examples, and an index with a search; `acausal list
electrical.Resistor` shows a class on the terminal. *Partial* classes, in slanted letters, are what
components are derived from.

<!-- Made by python -m acausal.reference.markdown; do not edit. -->
"""


def markdown_index(root: Root | None = None) -> str:
    """Return the page: a section for each package with its classes and their descriptions."""
    lines = [_HEAD]
    for package in packages(root or standard_library()):
        lines += [f"## {package.name}", "", *_rows(package), ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _rows(package: Package) -> list[str]:
    rows = [_row(c) for c in package.classes]
    if package.constants is not None:
        constants = package.constants.tree.components
        rows += [f"| `{c.name}` | {_cell(c.description)} |" for c in constants]
    return ["| class | |", "|---|---|", *rows]


def _row(definition: ClassDef) -> str:
    name = f"`{definition.name}`"
    if definition.tree.partial:
        name = f"*{name}*"
    return f"| {name} | {_cell(definition.tree.description)} |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    print(markdown_index(), end="")
