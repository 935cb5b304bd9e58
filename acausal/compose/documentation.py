"""Docstrings and signatures of component classes, made from the source of the library."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

from acausal.modeling.classes import ClassDef
from acausal.modeling.listing import Entry, entries


def describe_class(definition: ClassDef) -> str:
    """Return a docstring: description, cuts, parameters with units and defaults, variables."""
    lines = [definition.tree.description or f"{definition.kind} {definition.full_name}"]
    lines += ["", f"{definition.kind} {definition.full_name}"]
    if definition.tree.enumeration is not None:
        lines += ["", "Values:"]
        lines += [f"    {n}{': ' if t else ''}{t}" for n, t in definition.tree.enumeration]
        return "\n".join(lines)
    if definition.kind == "function":
        return "\n".join(lines)
    found = entries(definition)
    for kind, title in (("parameter", "Args"), ("cut", "Cuts"), ("variable", "Variables"),
                        ("component", "Components")):  # fmt: skip
        rows = [e for e in found if e.kind == kind]
        if rows:
            lines += ["", f"{title}:", *(_row(e) for e in rows)]
    return "\n".join(lines)


def _row(entry: Entry) -> str:
    unit = f" [{entry.unit}]" if entry.unit else ""
    default = f" = {entry.default}" if entry.default and entry.kind == "parameter" else ""
    about = f": {entry.description}" if entry.description else ""
    return f"    {entry.name} ({entry.type_name}{unit}){default}{about}"


class _Default:
    """A default as it is written in the source; shown without quotes."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def signature_of(cls: Any) -> inspect.Signature:
    """Return the signature of a component class: its parameters with their defaults."""
    keyword = inspect.Parameter.KEYWORD_ONLY
    rows: dict[str, inspect.Parameter] = {}
    build = getattr(cls, "build", None)
    if build is not None:
        for name, parameter in list(inspect.signature(build).parameters.items())[1:]:
            if parameter.kind not in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL):
                rows[name] = parameter.replace(kind=keyword)
    for base in cls._text_bases:
        for entry in entries(base):
            if entry.kind == "parameter":
                name = entry.name.partition("[")[0]
                rows.setdefault(name, _parameter(name, entry.default))
    for name, part in cls._declared.items():
        if part._role == "parameter":
            value = getattr(part, "_value", None)
            rows.setdefault(name, _parameter(name, "" if value is None else repr(value)))
    for name, (value, _) in cls._overrides.items():
        if name in rows:
            rows[name] = _parameter(name, repr(value))
    leading: Sequence[inspect.Parameter] = ()
    if any(base.__name__ == "Model" for base in cls.__mro__):
        positional = inspect.Parameter.POSITIONAL_OR_KEYWORD
        leading = (
            inspect.Parameter("name", positional, default=None),
            inspect.Parameter("description", positional, default=""),
        )
    extra = (
        inspect.Parameter("shape", keyword, default=()),
        inspect.Parameter("inner", keyword, default=None),
        *([] if leading else [inspect.Parameter("description", keyword, default="")]),
        inspect.Parameter("modifiers", inspect.Parameter.VAR_KEYWORD),
    )
    known = {p.name for p in (*leading, *extra)}
    own = [p for n, p in rows.items() if n not in known and n.isidentifier()]
    return inspect.Signature([*leading, *own, *extra])


def _parameter(name: str, default: str) -> inspect.Parameter:
    return inspect.Parameter(
        name,
        inspect.Parameter.KEYWORD_ONLY,
        default=_Default(default) if default else inspect.Parameter.empty,
    )
