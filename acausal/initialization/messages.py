"""Why a start fails, in the user's words."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from acausal.diagnostics import Diagnostic, Label, Severity, Span, fail
from acausal.flattening.model import Ids
from acausal.initialization.blocks import BlockSolution
from acausal.initialization.conditions import Conditions
from acausal.initialization.newton import Outcome
from acausal.initialization.problem import StartEquations
from acausal.initialization.system import StartSystem
from acausal.initialization.texts import LIST, Failure, first_failure, listed, row_text

HELP = {
    Outcome.SINGULAR: "give other start values, or check whether these equations have one solution",
    Outcome.STUCK: "give start values nearer to the solution for these variables",
    Outcome.SLOW: "give start values nearer to the solution for these variables",
    Outcome.NOT_FINITE: "give a start value for which the equation can be evaluated",
    Outcome.NOT_FINITE_JACOBIAN: "give a start value at which the equation has a finite slope",
}


def condition_text(system: StartSystem, variable: int) -> str:
    """Return a start condition as it is written."""
    value = system.variables.start[variable]
    fixed = ", fixed = true" if system.variables.fixed[variable] else ""
    return f"{system.names.variable(variable)}(start = {value:g}{fixed})"


def condition_labels(system: StartSystem, ids: Ids) -> list[Label]:
    """Return labels at the declarations of variables with start conditions."""
    labels = []
    for variable in ids[:LIST].tolist():
        span = system.names.declaration(variable)
        if span is not None:
            labels.append(Label(span, condition_text(system, variable)))
    return labels


def fail_free(system: StartSystem, conditions: Conditions) -> NoReturn:
    """Report unknowns that nothing determines (I011)."""
    names = [system.names.variable(v) for v in conditions.free[: LIST + 1].tolist()]
    count = conditions.free.shape[0]
    more = f" and {count - LIST} more" if count > LIST else ""
    fail(
        "I011",
        f"nothing determines the start of {', '.join(names[:LIST])}{more}",
        system.names.declaration(int(conditions.free[0])),
        labels=condition_labels(system, conditions.free[1:]),
        notes=[f"{count} initial condition{'s are' if count > 1 else ' is'} missing"],
        help=f"write {names[0]}(start = ..., fixed = true), or an initial equation",
    )


def fail_conflict(
    equations: StartEquations, conditions: Conditions, violated: list[str]
) -> NoReturn:
    """Report more initial conditions than degrees of freedom that contradict (I010)."""
    system = equations.system
    ids = conditions.conflict_ids
    initial = conditions.conflict_rows[conditions.conflict_rows >= system.n_rows]
    model = conditions.conflict_rows[conditions.conflict_rows < system.n_rows]
    surplus = conditions.surplus_rows
    initial = np.union1d(initial, surplus[surplus >= system.n_rows])
    texts = [condition_text(system, v) for v in ids[: 2 * LIST].tolist()]
    labels = condition_labels(system, ids)
    for row in initial[:LIST].tolist():
        words, span = row_text(equations, row)
        texts.append(f"initial equation {words}")
        if span is not None:
            labels.append(Label(span, "this initial equation"))
    # An equation and its derivatives have the same words.
    reasons = list(dict.fromkeys(row_text(equations, row) for row in model[: 4 * LIST].tolist()))
    labels += [Label(span, words) for words, span in reasons if span is not None]
    too_many = surplus.shape[0] + conditions.surplus_fixed.shape[0]
    first = labels[0].span if labels else None
    fail(
        "I010",
        f"the initial conditions contradict each other: {listed(violated)}",
        first,
        label=labels[0].text if labels else "",
        labels=labels[1:],
        notes=[
            f"{too_many} of these {'is' if too_many == 1 else 'are'} too many: "
            + listed(texts, 2 * LIST),
            *([f"they are linked by {listed([w for w, _ in reasons])}"] if reasons else []),
        ],
        help="remove fixed = true from one of these variables, or make the values agree",
    )


def fail_block(equations: StartEquations, solution: BlockSolution, when: str) -> NoReturn:
    """Report a block that could not be solved (I020, I021 singular, I030 not finite)."""
    assert solution.failed is not None
    assert solution.problem is not None
    assert solution.guess is not None
    problem, system = solution.problem, equations.system
    result = solution.failed.result
    names = [system.names.variable(v) for v in problem.ids[: LIST + 1].tolist()]
    more = f" and {problem.n - LIST} more" if problem.n > LIST else ""
    unknowns = ", ".join(names[:LIST]) + more
    worst = problem.rows[np.argsort(-result.error, kind="stable")]
    if result.outcome is Outcome.NOT_FINITE:
        problem.put(solution.guess)
        failure = first_failure(problem, system.names)
        if failure is not None:
            text, span = row_text(equations, failure[0])
            fail_not_finite(system, failure[1], text, span, when)
    rows = list(dict.fromkeys(row_text(equations, row) for row in worst[:LIST].tolist()))
    code = "I021" if result.outcome is Outcome.SINGULAR else "I020"
    spans = [Label(span, words) for words, span in rows if span is not None]
    fail(
        code,
        f"no solution found for {unknowns} {when}: {result.outcome.value}",
        spans[0].span if spans else system.names.declaration(int(problem.ids[0])),
        label=spans[0].text if spans else "",
        labels=spans[1:],
        notes=[
            f"equations, the worst first: {listed([words for words, _ in rows])}",
            "last values: "
            + listed(
                [
                    f"{name} = {value:g}"
                    for name, value in zip(names, result.x.tolist(), strict=False)
                ]
            ),
        ],
        help=HELP[result.outcome],
    )


def fail_not_finite(
    system: StartSystem, failure: Failure, text: str, span: Span | None, when: str
) -> NoReturn:
    """Report an equation that cannot be evaluated (I030)."""
    names = system.names
    advice = "look at the values that enter this equation"
    if failure.variables:
        variable = failure.variables[0]
        fixed = system.variables.fixed[variable]
        advice = f"give {names.variable(variable)} {'another' if fixed else 'a'} start value"
    elif failure.parameters:
        advice = f"give the parameter {names.parameter(failure.parameters[0])} another value"
    fail(
        "I030",
        f"{failure.words} {when}",
        span,
        label=text,
        labels=condition_labels(system, np.array(failure.variables, dtype=np.int64)),
        notes=[f"equation: {text}"],
        help=advice,
    )


def fail_large(equations: StartEquations, outcome: Outcome, rows: Ids, when: str) -> NoReturn:
    """Report a large system that could not be solved as a whole (I020)."""
    words = [row_text(equations, row) for row in rows[:LIST].tolist()]
    span = next((s for _, s in words if s is not None), None)
    fail(
        "I020",
        f"no solution found {when}: {outcome.value}",
        span,
        notes=[f"the worst equations: {listed([w for w, _ in words])}"],
        help=HELP[outcome],
    )


def default_starts(system: StartSystem, ids: Ids) -> Diagnostic:
    """Return the warning that states start at a default nobody wrote (I101)."""
    texts = [
        f"{system.names.variable(v)} = {system.variables.start[v]:g}" for v in ids[:LIST].tolist()
    ]
    more = f" and {ids.shape[0] - LIST} more" if ids.shape[0] > LIST else ""
    return Diagnostic(
        "I101",
        f"no start value is written for {', '.join(texts)}{more}; the default is used",
        system.names.declaration(int(ids[0])),
        help=f"write {system.names.variable(int(ids[0]))}(start = ..., fixed = true)",
        severity=Severity.WARNING,
    )
