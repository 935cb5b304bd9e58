"""Stage parse: the class as the parser has understood it."""

from __future__ import annotations

from acausal.modeling.classes import ClassDef
from acausal.syntax.formatter import format_class


def show_parse(definition: ClassDef) -> list[str]:
    """Return the source of the class, formatted anew, and where its bases come from."""
    lines = format_class(definition.tree).rstrip("\n").split("\n")
    bases = [b.full_name for b, _ in definition.bases]
    if bases:
        lines.append(f"// extends {', '.join(bases)}")
    return lines
