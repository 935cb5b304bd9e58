"""Diagnostics are data; an :class:`AcausalError` carries one or more of them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from typing import NoReturn

from acausal.diagnostics.span import Span


class Severity(Enum):
    """How bad it is."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Label:
    """A secondary place with a remark, e.g. where the other source is declared."""

    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One message to a person.

    Attributes:
        code: Stage letter and number, e.g. ``S103``. The letters are owned by the stages:
            ``P`` parse, ``N`` names, ``T`` types and sizes, ``U`` units, ``C`` connections,
            ``B`` balance, ``S`` structure, ``I`` initialisation, ``E`` events, ``R`` run time,
            ``F`` files and command line.
        message: One sentence in the user's words, no full stop.
        span: The primary place, if there is one.
        label: A remark printed under the primary place.
        labels: Further places.
        notes: Facts that help to understand.
        help: What to do.
        severity: Error or warning.
    """

    code: str
    message: str
    span: Span | None = None
    label: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: str = ""
    severity: Severity = Severity.ERROR


class AcausalError(Exception):
    """A user's mistake or a failed run, told as diagnostics (never empty)."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(f"error[{d.code}]: {d.message}" for d in self.diagnostics))

    def __str__(self) -> str:
        """Return the diagnostics with the marked source, as the command line shows them."""
        from acausal.diagnostics.render import render

        return render(self).rstrip()

    def _render_traceback_(self) -> list[str]:
        """Return what IPython and Jupyter show: the user's own lines, and the message."""
        from acausal.diagnostics.notebook import rendered

        return rendered(self)

    def __reduce__(self) -> tuple[type[AcausalError], tuple[tuple[Diagnostic, ...]]]:
        return (type(self), (self.diagnostics,))


def fail(
    code: str,
    message: str,
    span: Span | None = None,
    *,
    label: str = "",
    labels: Iterable[Label] = (),
    notes: Iterable[str] = (),
    help: str = "",  # noqa: A002 - the field's own name
) -> NoReturn:
    """Raise an :class:`AcausalError` with one diagnostic.

    Raises:
        AcausalError: Always.
    """
    raise AcausalError([Diagnostic(code, message, span, label, tuple(labels), tuple(notes), help)])
