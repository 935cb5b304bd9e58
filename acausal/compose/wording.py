"""Expressions in words, for messages and the prompt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from acausal.diagnostics import Span
from acausal.syntax import tree
from acausal.syntax.formatter import format_expression

if TYPE_CHECKING:
    from acausal.compose.parts import Part
    from acausal.compose.symbols import Symbolic

_SPAN = Span("<words>", 1, 1, 1, 1)
_LONGEST = 200


class _Anywhere:
    """Names every part from the outermost model on."""

    def path(self, part: Part, span: Span) -> list[str]:
        names: list[str] = []
        where: Any = part
        while where is not None and not isinstance(where, type):
            name = where._name or getattr(where, "_title", "") or f"<{where._kind.title}>"
            names.append(name)
            where = where._owner
        if where is None and len(names) > 1:
            names.pop()
        return list(reversed(names))

    def class_reference(self, what: object, span: Span) -> tree.Reference:
        name = str(getattr(what, "full_name", None) or getattr(what, "__name__", what))
        return tree.Reference(span, tuple(tree.NamePart(span, n) for n in name.split(".")))


def words(value: Symbolic) -> str:
    """Return an expression as text; names from the outermost model on."""
    text = format_expression(value._tree(_Anywhere(), _SPAN))
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
