"""The declarations of a class as text, to see what its equations have become."""

from __future__ import annotations

from collections.abc import Hashable

import pytest

from acausal.diagnostics import AcausalError
from acausal.expressions.nodes import Expr
from acausal.expressions.text import to_text
from acausal.instantiation.domain import at_pass
from acausal.instantiation.instantiate import instantiate
from acausal.instantiation.template import (
    INITIAL,
    LoopIndex,
    Ref,
    Signal,
    TableEntry,
    Template,
)
from acausal.modeling.load import choose_model, load_text


def template(text: str, model: str | None = None) -> Template:
    """Return the template of a model."""
    classes, _ = load_text(text)
    return instantiate(choose_model(classes, model, "the text"))[0][-1]


def code(text: str) -> str:
    """Return the code of the message that a model is refused with."""
    with pytest.raises(AcausalError) as caught:
        template(text)
    diagnostic = caught.value.diagnostics[0]
    assert diagnostic.help
    return diagnostic.code


def shown(expr: Expr | None) -> str:
    """Return an expression as text; signals are ``$0``, loop indices as they are named."""
    return "" if expr is None else to_text(expr, _slot)


def _slot(payload: Hashable) -> str:
    if isinstance(payload, Ref):
        steps = [*((s.name, s.index) for s in payload.path), (payload.name, payload.index)]
        text = ".".join(n + _index(i) for n, i in steps if n or i)
        text = f"{payload.outer}.{text}" if payload.outer else text
        text = "der(" * payload.order + text + ")" * payload.order
        return f"pre({text})" if payload.pre else text
    if isinstance(payload, Signal):
        name = f"${payload.number}"
        if payload.number < 0:
            name = "initial()" if payload.number == INITIAL else "terminal()"
        return f"pre({name})" if payload.pre else name
    if isinstance(payload, LoopIndex):
        return payload.name
    assert isinstance(payload, TableEntry)
    return "table" + _index(payload.index)


def _index(index: tuple[Expr, ...]) -> str:
    return f"[{','.join(shown(i) for i in index)}]" if index else ""


def assignments(own: Template, initial: bool = False) -> list[str]:
    """Return the discrete equations, a line for every pass of the loops around them."""
    return [
        f"{shown(at_pass(d.target, d.domain, k))} {'=' if d.symmetric else ':='} "
        f"{shown(at_pass(d.value, d.domain, k))}"
        for d in (own.initial_discrete if initial else own.discrete)
        for k in range(d.domain.length)
    ]


def equations(own: Template, initial: bool = False) -> list[str]:
    """Return the continuous equations in the same way."""
    return [
        shown(at_pass(e.residual, e.domain, k))
        for e in (own.initial_equations if initial else own.equations)
        for k in range(e.domain.length)
    ]


def signals(own: Template) -> list[str]:
    """Return the signals in the same way."""
    return [
        f"{s.kind}({', '.join(shown(at_pass(o, s.domain, k)) for o in s.operands)})"
        for s in own.signals
        for k in range(s.domain.length)
    ]


def reinits(own: Template) -> list[str]:
    """Return the reinits in the same way."""
    return [
        f"{shown(at_pass(r.state, r.domain, k))} := {shown(at_pass(r.value, r.domain, k))} "
        f"at {shown(at_pass(r.fires, r.domain, k))}"
        + (f" impulse {shown(at_pass(r.impulse, r.domain, k))}" if r.impulse is not None else "")
        for r in own.reinits
        for k in range(r.domain.length)
    ]
