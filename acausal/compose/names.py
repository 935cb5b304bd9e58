"""Names of parts: identifiers that neither the language nor Python uses for something else."""

from __future__ import annotations

from typing import Any

from acausal.diagnostics import Span, fail

#: Reserved words of the language.
RESERVED = frozenset((
    "algorithm", "and", "annotation", "block", "break", "class", "connect", "connector",
    "constant", "constrainedby", "der", "discrete", "each", "else", "elseif", "elsewhen",
    "encapsulated", "end", "enumeration", "equation", "expandable", "extends", "external",
    "false", "final", "flow", "for", "function", "if", "import", "impure", "in", "initial",
    "inner", "input", "loop", "model", "not", "operator", "or", "outer", "output", "package",
    "parameter", "partial", "protected", "public", "pure", "record", "redeclare", "replaceable",
    "return", "stream", "then", "true", "type", "when", "while", "within",
    "time",
))  # fmt: skip


def check_name(name: str, span: Span, owner: Any = None) -> None:
    """Refuse a name that a part cannot have.

    Args:
        name: The name.
        span: The place.
        owner: The Python class of the model, whose methods keep their names.

    Raises:
        AcausalError: ``N151``.
    """
    if not (name.isidentifier() and name.isascii()):
        good = "".join(c if c.isascii() and (c.isalnum() or c == "_") else "_" for c in name)
        good = good if good[:1].isalpha() else f"part_{good}"
        fail("N151", f"{name!r} is no name", span,
             label="a name has letters, digits and _, and begins with a letter",
             help=f"write {good}")  # fmt: skip
    if name in RESERVED:
        fail("N151", f"{name} is a reserved word of the language", span, help=f"write {name}_")
    if owner is not None and hasattr(owner, name):
        what = "a method" if callable(getattr(owner, name)) else "an attribute"
        fail("N151", f"{name} is {what} of every {owner.__name__}", span, help=f"write {name}_")
