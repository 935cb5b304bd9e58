"""Templates that are linear with literal coefficients: how aliases are recognised."""

from __future__ import annotations

from dataclasses import dataclass

from acausal.expressions.build import add, div, mul, neg, sub
from acausal.expressions.linearity import split_linear
from acausal.expressions.nodes import ONE, ZERO, Expr, const, slot
from acausal.expressions.traverse import postorder, slots, substitute


@dataclass(frozen=True)
class LinearForm:
    """``sum(coefficients[j] * slot(j)) + constant``.

    Attributes:
        coefficients: Non-zero literal coefficient by slot, in order of first appearance.
        constant: Literal rest.
    """

    coefficients: dict[int, float]
    constant: float


def linear_form(template: Expr) -> LinearForm | None:
    """Return the template as a sum of slots with literal coefficients, or None."""
    forms: dict[Expr, tuple[dict[int, float], float]] = {}
    for item in postorder(template):
        parts = [forms[argument] for argument in item.args]
        match item.op:
            case "const":
                assert isinstance(item.value, float)
                forms[item] = {}, item.value
            case "slot":
                assert isinstance(item.value, int)
                forms[item] = {item.value: 1.0}, 0.0
            case "neg":
                forms[item] = _combined(parts[0], parts[0], -1.0, 0.0)
            case "add":
                forms[item] = _combined(parts[0], parts[1], 1.0, 1.0)
            case "sub":
                forms[item] = _combined(parts[0], parts[1], 1.0, -1.0)
            case "mul" if not parts[0][0]:
                forms[item] = _combined(parts[1], parts[1], parts[0][1], 0.0)
            case "mul" if not parts[1][0]:
                forms[item] = _combined(parts[0], parts[0], parts[1][1], 0.0)
            case "div" if not parts[1][0] and parts[1][1] != 0.0:
                forms[item] = _combined(parts[0], parts[0], 1.0 / parts[1][1], 0.0)
            case _:
                return None
    coefficients, constant = forms[template]
    return LinearForm({j: c for j, c in coefficients.items() if c != 0.0}, constant)


def _combined(
    a: tuple[dict[int, float], float], b: tuple[dict[int, float], float], p: float, q: float
) -> tuple[dict[int, float], float]:
    if q == 0.0:
        return {j: p * c for j, c in a[0].items()}, p * a[1]
    total = {j: p * c for j, c in a[0].items()}
    for j, c in b[0].items():
        total[j] = total.get(j, 0.0) + q * c
    return total, p * a[1] + q * b[1]


def tidied(template: Expr) -> Expr:
    """Return ``template`` simplified after a substitution.

    What is linear with literal coefficients gets one normal form, positive terms first; in
    anything else a slot that cancels (``R*(a - b) + R*b``) disappears, so that no incidence is
    left that is none.
    """
    form = linear_form(template)
    if form is not None:
        return _normal(form)
    for key in repeated_slots(template):
        split = split_linear(template, slot(key))
        if split is not None and split[0] is ZERO:
            template = split[1]
    return template


def _normal(form: LinearForm) -> Expr:
    total = ZERO
    terms = list(form.coefficients.items())
    for key, c in [t for t in terms if t[1] > 0.0]:
        total = add(total, slot(key) if c == 1.0 else mul(const(c), slot(key)))
    if form.constant > 0.0:
        total = add(total, const(form.constant))
    for key, c in [t for t in terms if t[1] < 0.0]:
        total = sub(total, slot(key) if c == -1.0 else mul(const(-c), slot(key)))
    return total if form.constant >= 0.0 else sub(total, const(-form.constant))


def repeated_slots(template: Expr) -> list[int]:
    """Return the slots that are reached on more than one way from the root."""
    ways: dict[Expr, int] = {template: 1}
    for item in reversed(postorder(template)):
        for argument in item.args:
            ways[argument] = min(2, ways.get(argument, 0) + ways[item])
    return [int(e.value) for e in ways if e.op == "slot" and ways[e] > 1]  # type: ignore[call-overload]


def solved_for(
    template: Expr, key: int, parameters: frozenset[int] = frozenset()
) -> tuple[Expr, Expr] | None:
    """Solve ``template = 0`` for a slot in which it is linear.

    Args:
        template: The row.
        key: The slot.
        parameters: Slots that the coefficient may depend on; none if it has to be a literal.

    Returns:
        ``(f, c)`` with ``slot(key) = f`` and ``c`` the coefficient that ``f`` is divided by;
        None if there is no such solution.
    """
    split = split_linear(template, slot(key))
    if split is None or split[0] is ZERO:
        return None
    coefficient, rest = split
    used = slots(coefficient)
    if not parameters.issuperset(used) or (not used and coefficient.op != "const"):
        return None
    if coefficient is ONE:
        return neg(rest), coefficient
    return neg(div(rest, coefficient)), coefficient


def shifted(template: Expr, offset: int) -> Expr:
    """Return the template with ``offset`` added to every slot number."""
    return substitute(template, {slot(k): slot(int(k) + offset) for k in slots(template)})  # type: ignore[call-overload]
