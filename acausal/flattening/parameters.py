"""Values of parameters and of the attributes of variables, computed family by family.

Of several bindings of one scalar the outermost wins: class templates are visited from the model
down, and the first binding claims its scalars. A binding is evaluated for all members whose
operands are known, again and again until nothing is left; what is left then depends on itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import Diagnostic, Severity, Span, fail
from acausal.expressions.build import number_of
from acausal.expressions.evaluate import evaluate
from acausal.expressions.nodes import ZERO, Expr
from acausal.flattening.families import FamilyBuilder
from acausal.flattening.model import Ids, Operand
from acausal.flattening.names import NumberingNames
from acausal.instantiation.numbering import Numbering
from acausal.instantiation.template import BindingDecl, Template


@dataclass
class Step:
    """Members of a binding: ``targets`` get the value of ``template`` at ``operands``."""

    targets: Ids
    template: Expr
    operands: Ids
    span: Span


def parameter_values(
    numbering: Numbering,
    builder: FamilyBuilder,
    names: NumberingNames,
    given: dict[int, float],
    warnings: list[Diagnostic],
    steps: list[Step] | None = None,
) -> NDArray[np.float64]:
    """Return the values of all declared parameters, shape ``(n_parameters,)``.

    Args:
        numbering: Ids.
        builder: Resolves references.
        names: Paths for messages.
        given: Values set by the caller, by parameter id; they win over everything.
        warnings: Receives a warning for every parameter that falls back to its start value.
        steps: Receives what was computed from other parameters, in order of evaluation.

    Raises:
        AcausalError: ``N112`` for parameters without a value, ``N117`` for circular ones,
            ``T134`` for one that depends on a variable.
    """
    values = np.full(numbering.n_parameters, np.nan)
    known = np.zeros(numbering.n_parameters, np.bool_)
    claimed = np.zeros(numbering.n_parameters, np.bool_)
    if given:
        ids = np.array(list(given), np.int64)
        values[ids] = list(given.values())
        known[ids] = claimed[ids] = True
    pending: list[Step] = []
    starts: list[tuple[Template, BindingDecl]] = []
    for template, binding in _outermost_first(numbering, True, ("value", "start", "fixed")):
        if binding.attribute == "fixed" and binding.value is ZERO:
            fail("E004", f"{binding.target.name} is a parameter with fixed = false", binding.span,
                 label="it would have to be found at the start of the simulation",
                 help="compute it from other parameters")  # fmt: skip
        if binding.attribute == "start":
            starts.append((template, binding))
        if binding.attribute == "value":
            if _is_number(binding.value):
                single = numbering.single_id(template, binding.target, binding.domain)
                if single is not None:
                    if not claimed[single]:
                        claimed[single] = known[single] = True
                        values[single] = binding.value.value
                    continue
                free = _free(numbering, template, binding, claimed)
                values[free], known[free] = number_of(binding.value), True
                continue
            _claim(numbering, builder, template, binding, claimed, pending)
    for template, binding in starts:
        before = len(pending)
        _claim(numbering, builder, template, binding, claimed, pending)
        for item in pending[before:]:
            warnings.append(
                Diagnostic(
                    "N120",
                    f"parameter {names.parameter(int(item.targets[0]))} has no value; "
                    "its start value is used",
                    item.span,
                    help="set it where the component is declared",
                    severity=Severity.WARNING,
                )
            )
    if not claimed.all():
        _missing(numbering, names, np.flatnonzero(~claimed))
    _solve(pending, values, known, builder, names, [] if steps is None else steps)
    return values


def _outermost_first(
    numbering: Numbering, parameters: bool, attributes: tuple[str, ...]
) -> list[tuple[Template, BindingDecl]]:
    """Return the bindings of attributes of parameters or of variables, strong ones first."""
    sorted_ = numbering.bindings
    if not sorted_:
        for group in reversed(numbering.groups):
            if group.count:
                template = group.template
                for binding in template.bindings:
                    key = (binding.target.parameter, binding.attribute, binding.weak)
                    sorted_.setdefault(key, []).append((template, binding))
    return [
        pair
        for weak in (False, True)
        for attribute in attributes
        for pair in sorted_.get((parameters, attribute, weak), ())
    ]


def _is_number(value: Expr) -> bool:
    return value.op == "const" and not math.isnan(number_of(value))


def _free(
    numbering: Numbering, template: Template, binding: BindingDecl, claimed: NDArray[np.bool_]
) -> Ids:
    """Return the targets that nothing further outside has set, and claim them.

    Raises:
        AcausalError: ``T114`` for a subscript out of range.
    """
    try:
        targets = numbering.ids(template, binding.target, binding.domain)
    except IndexError as error:
        index, n = error.args
        fail("T114", f"subscript {index} is outside 1..{n}", binding.span,
             help=f"the array has {n} elements")  # fmt: skip
    free = targets[~claimed[targets]]
    claimed[free] = True
    return free


def _claim(
    numbering: Numbering,
    builder: FamilyBuilder,
    template: Template,
    binding: BindingDecl,
    claimed: NDArray[np.bool_],
    pending: list[Step],
) -> None:
    try:
        targets = numbering.ids(template, binding.target, binding.domain)
        free = ~claimed[targets]
        if not free.any():
            return
        claimed[targets[free]] = True
        body, kinds, operands = builder.canonical(template, binding.value, binding.domain)
    except IndexError as error:
        index, n = error.args
        fail("T114", f"subscript {index} is outside 1..{n}", binding.span,
             help=f"the array has {n} elements")  # fmt: skip
    if Operand.VARIABLE in kinds:
        fail("T134", f"{binding.target.name} cannot depend on a variable", binding.span,
             label="variables change during the simulation",
             help="use parameters and constants here")  # fmt: skip
    pending.append(Step(targets[free], body, operands[:, free], binding.span))


def _solve(
    pending: list[Step],
    values: NDArray[np.float64],
    known: NDArray[np.bool_],
    builder: FamilyBuilder,
    names: NumberingNames,
    steps: list[Step],
) -> None:
    n = len(values)
    while pending:
        # Literals are numbered behind the declared parameters and are always known.
        literal = builder.literals.values
        every = np.concatenate([values, *literal]) if literal else values
        ready_of = np.concatenate([known, np.ones(len(every) - n, np.bool_)])
        waiting: list[Step] = []
        progress = False
        for item in pending:
            if len(item.operands):
                ready = ready_of[item.operands].all(axis=0)
            else:
                ready = np.ones(len(item.targets), np.bool_)
            if ready.any():
                progress = True
                operands = item.operands[:, ready]
                steps.append(Step(item.targets[ready], item.template, operands, item.span))
                given = {k: every[row] for k, row in enumerate(operands)}
                result = evaluate(item.template, given)
                targets = item.targets[ready]
                values[targets] = result
                every[targets] = result
                known[targets] = ready_of[targets] = True
                bad = targets[~np.isfinite(values[targets]) & ~np.isinf(values[targets])]
                if len(bad):
                    fail("I010", f"the value of {names.parameter(int(bad[0]))} is not a number",
                         item.span,
                         help="check for 0/0 or a root of a negative number")  # fmt: skip
            if not ready.all():
                left = ~ready
                waiting.append(
                    Step(item.targets[left], item.template, item.operands[:, left], item.span)
                )
        if not progress:
            item = waiting[0]
            others = [names.parameter(int(w.targets[0])) for w in waiting[:4]]
            fail("N117", f"the value of {others[0]} depends on itself", item.span,
                 notes=[f"in the circle: {', '.join(others)}"],
                 help="give one of them a value of its own")  # fmt: skip
        pending = waiting


def _missing(numbering: Numbering, names: NumberingNames, ids: Ids) -> None:
    for block in numbering.parameters:
        unfit = numbering.groups[block.group].template.unfit_defaults
        if (
            block.declaration.name in unfit
            and ((ids >= block.first) & (ids < block.first + block.count)).any()
        ):
            raise unfit[block.declaration.name]
    first = [names.parameter(int(i)) for i in ids[:5]]
    more = f" and {len(ids) - 5} more" if len(ids) > 5 else ""
    fail(
        "N112",
        f"{', '.join(first)}{more} {'has' if len(ids) == 1 else 'have'} no value",
        names.parameter_declaration(int(ids[0])),
        label="declared without a value",
        help=f"set it where the component is declared, or run with -p {first[0]}=…",
    )


def attribute_values(
    numbering: Numbering,
    builder: FamilyBuilder,
    parameters: NDArray[np.float64],
    attribute: str,
    default: float,
    *,
    parameter_targets: bool = False,
    steps: list[Step] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return one attribute of all variables, and where a declaration or modifier set it.

    ``steps`` receives what was computed from parameters.

    Returns:
        Values and flags, both of shape ``(n_variables,)`` (or of the parameters).

    Raises:
        AcausalError: ``T134`` if it depends on a variable.
    """
    n = numbering.n_parameters if parameter_targets else numbering.n_variables
    values = np.full(n, default)
    claimed = np.zeros(n, np.bool_)
    given = np.zeros(n, np.bool_)
    for template, binding in _outermost_first(numbering, parameter_targets, (attribute,)):
        if _is_number(binding.value):
            single = numbering.single_id(template, binding.target, binding.domain)
            if single is not None:
                if not claimed[single]:
                    claimed[single] = True
                    values[single] = binding.value.value
                    given[single] |= not binding.weak
                continue
            free = _free(numbering, template, binding, claimed)
            values[free] = number_of(binding.value)
            given[free] |= not binding.weak
            continue
        pending: list[Step] = []
        _claim(numbering, builder, template, binding, claimed, pending)
        if steps is not None:
            steps += pending
        for item in pending:
            every = np.concatenate([parameters, *builder.literals.values])
            operands = {k: every[row] for k, row in enumerate(item.operands)}
            values[item.targets] = evaluate(item.template, operands)
            if not binding.weak:
                given[item.targets] = True
    return values, given
