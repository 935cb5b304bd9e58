"""Algorithm sections of models."""

from __future__ import annotations

from acausal.diagnostics import fail
from acausal.instantiation.environment import ClassEnvironment
from acausal.instantiation.sinks import Sink
from acausal.syntax import tree


def add_algorithm(
    statements: tuple[tree.Statement, ...], env: ClassEnvironment, sink: Sink
) -> None:
    if statements:
        fail("E008", "algorithm", statements[0].span, help="x")
