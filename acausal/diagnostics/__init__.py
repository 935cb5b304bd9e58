"""Coded diagnostics: what went wrong, where, and what to do about it."""

from acausal.diagnostics.diagnostic import (
    AcausalError,
    Diagnostic,
    Label,
    Severity,
    fail,
)
from acausal.diagnostics.span import Span

__all__ = ["AcausalError", "Diagnostic", "Label", "Severity", "Span", "fail"]
