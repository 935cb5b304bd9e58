"""Syntax errors in the user's words."""

from __future__ import annotations

from typing import NoReturn

from lark.exceptions import UnexpectedInput

from acausal.diagnostics import Span, fail


def explain(error: UnexpectedInput, text: str, source: str, start: str) -> NoReturn:
    """Raise the diagnostic for a syntax error.

    Raises:
        AcausalError: Always.
    """
    fail("P001", str(error).splitlines()[0], Span(source, error.line, error.column, error.line, error.column+1))
