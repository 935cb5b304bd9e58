# ruff: noqa: A004, F401 - type checkers see the names that are imported when first used
"""Acausal multiport modelling and simulation.

Example:
    >>> import acausal as ac
    >>> result = ac.compile_file("examples/rlc.acm").simulate(stop_time=0.1)
    >>> result["c.v"].unit
    'V'
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acausal.compiler import Compiled, compile_file, compile_text
    from acausal.compose.component import Component, Connector
    from acausal.compose.declarations import (
        Across,
        Constant,
        Discrete,
        Parameter,
        Through,
        Variable,
    )
    from acausal.compose.equations import assert_, if_then, reinit, terminate, when
    from acausal.compose.functions import (
        abs,
        acos,
        and_,
        asin,
        atan,
        atan2,
        ceil,
        change,
        cos,
        cosh,
        cross,
        delay,
        der,
        edge,
        exp,
        floor,
        function,
        homotopy,
        initial,
        log,
        log10,
        max,
        min,
        no_event,
        not_,
        or_,
        pre,
        product,
        sample,
        sign,
        sin,
        sinh,
        size,
        smooth,
        sqrt,
        sum,
        tan,
        tanh,
        terminal,
        time,
        transpose,
        where,
    )
    from acausal.compose.loading import load
    from acausal.compose.model import Model
    from acausal.compose.modifiers import mod
    from acausal.diagnostics import AcausalError
    from acausal.netlists.chains import chain
    from acausal.netlists.graphs import from_graph
    from acausal.netlists.spice.reader import read_spice
    from acausal.results.files import read_result
    from acausal.results.result import Result, plot_runs
    from acausal.results.trajectory import Trajectory

__all__ = ["AcausalError", "Compiled", "Result", "compile_file", "compile_text", "read_result"]

# Names are imported when first used: importing the package must cost next to nothing.
_HOMES = {
    "AcausalError": "acausal.diagnostics",
    "Compiled": "acausal.compiler",
    "Result": "acausal.results.result",
    "compile_file": "acausal.compiler",
    "compile_text": "acausal.compiler",
    "read_result": "acausal.results.files",
}
# Many runs, and runs that go on.
_HOMES |= dict.fromkeys(("simulate_many", "sweep"), "acausal.runs.sweep")
_HOMES |= {"Study": "acausal.runs.study", "plot_runs": "acausal.results.result"}
_HOMES |= {"Trajectory": "acausal.results.trajectory"}
_HOMES |= {"Animation": "acausal.animation.animation"}
_HOMES |= dict.fromkeys(("Snapshot", "read_snapshot"), "acausal.results.snapshot")
# Models made of data.
_HOMES |= {
    "chain": "acausal.netlists.chains",
    "from_graph": "acausal.netlists.graphs",
    "read_spice": "acausal.netlists.spice.reader",
}
# Models composed in Python.
_HOMES |= dict.fromkeys(("Component", "Connector"), "acausal.compose.component")
_HOMES |= {
    "Model": "acausal.compose.model",
    "load": "acausal.compose.loading",
    "mod": "acausal.compose.modifiers",
}
_HOMES |= dict.fromkeys(
    ("Across", "Constant", "Discrete", "Parameter", "Through", "Variable"),
    "acausal.compose.declarations",
)
_HOMES |= dict.fromkeys(
    ("assert_", "if_then", "reinit", "terminate", "when"), "acausal.compose.equations"
)
_HOMES |= dict.fromkeys(
    (
        *("abs", "acos", "and_", "asin", "atan", "atan2", "ceil", "change", "cos", "cosh", "cross"),
        *("delay", "der", "edge", "exp", "floor", "function", "homotopy", "initial", "log"),
        *("log10", "max", "min", "no_event", "not_", "or_", "pre", "product", "sample", "sign"),
        *("sin", "sinh", "size", "smooth", "sqrt", "sum", "tan", "tanh", "terminal", "time"),
        *("transpose", "where"),
    ),
    "acausal.compose.functions",
)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'acausal' has no attribute {name!r}")
    from importlib import import_module

    value = globals()[name] = getattr(import_module(_HOMES[name]), name)
    return value


def __dir__() -> list[str]:
    return sorted(_HOMES)
