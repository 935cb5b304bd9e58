"""Mistakes in Python that Python itself has a class of exceptions for."""

from __future__ import annotations

import dis
import sys
from collections.abc import Iterable
from dataclasses import replace
from typing import NoReturn

from acausal.diagnostics import AcausalError, Diagnostic, Span
from acausal.diagnostics.suggest import nearest


class UnknownNameError(AcausalError, AttributeError):
    """A name that a component or package does not have; ``hasattr`` understands it."""


class UnknownImportError(AcausalError, ImportError):
    """A name that ``from package import name`` does not find."""


def in_terms_of_python(error: AcausalError, model: str) -> AcausalError:
    """Return an error of the compiler with the advice that a user of Python needs."""
    changed = []
    for d in error.diagnostics:
        if d.code == "N118":
            *_, kind, name = d.help.rstrip(";").split()
            d = replace(d, help=f"give the model one: {model}.{name} = ...{kind}()")
        elif d.code == "T118":
            d = replace(d, help="give one value for all, or an array of the components' size")
        changed.append(d)
    return AcausalError(changed)


def unknown_name(
    code: str, message: str, span: Span, name: str, known: Iterable[str], otherwise: str
) -> NoReturn:
    """Refuse a name, with the nearest ones.

    Raises:
        UnknownNameError: Always.
    """
    close = nearest(name, known)
    notes = (f"did you mean {' or '.join(close)}?",) if close else ()
    help_ = f"write {close[0]}, if that is what you mean" if close else otherwise
    kind = UnknownImportError if _importing() else UnknownNameError
    raise kind([Diagnostic(code, message, span, notes=notes, help=help_)])


def _importing() -> bool:
    """Tell whether the user's line is ``from package import name``.

    Python replaces an AttributeError there by one of its own, without our advice.
    """
    frame = sys._getframe(1)
    while frame.f_globals.get("__name__", "").startswith("acausal.") and frame.f_back is not None:
        frame = frame.f_back
    return dis.opname[frame.f_code.co_code[frame.f_lasti]] == "IMPORT_FROM"
