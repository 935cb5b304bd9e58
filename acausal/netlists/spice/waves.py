"""Values of independent sources: constants and wave forms, with SPICE's defaults."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, cast

from acausal.compose.component import Component
from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.packages import package
from acausal.netlists.spice.cards import Element
from acausal.netlists.spice.expressions import value_of
from acausal.netlists.spice.lines import Token
from acausal.netlists.spice.scope import Scope, Value, constant

#: Wave form -> names of its values in the library; ``{0}`` is V or I.
WAVES = {
    "sin": ("{0}O", "{0}A", "FREQ", "TD", "THETA"),
    "pulse": ("{0}1", "{0}2", "TD", "TR", "TF", "PW", "PER"),
    "exp": ("{0}1", "{0}2", "TD1", "TAU1", "TD2", "TAU2"),
    "sffm": ("{0}O", "{0}A", "FC", "MDI", "FS"),
    "pwl": (),
}


def source(scope: Scope, element: Element) -> Component:
    """Return the component of an independent source.

    Raises:
        AcausalError: ``P040``, ``P041`` for what is not understood.
    """
    spice = package("electrical.spice")

    letter = element.letter
    words = list(element.words[2:])
    value: Value | None = None
    for key, (token, given) in element.options.items():
        if key == "dc":
            value = scope.value(given)
        elif key not in ("ac", "acmag", "acphase"):
            _unknown(token)
    while words:
        word = words.pop(0)
        if word.low == "dc" and words:
            value = scope.value(value_of(words.pop(0)))
        elif word.low == "ac":  # small signals: not simulated
            while words and words[0].low not in (*WAVES, "dc"):
                words.pop(0)
        elif word.low in WAVES:
            return _wave(scope, element, word, words)
        elif word.kind == "word" and word.text[0].isalpha() and value is not None:
            _unknown(word)
        elif value is None:
            if word.kind == "word" and words and words[0].text == "(":
                _unknown(word)
            value = scope.value(value_of(word))
        else:
            _unknown(word)
    value = constant(0.0) if value is None else value
    return cast(Component, getattr(spice, f"{letter}_constant")(**{letter: value.given}))


def _unknown(token: Token) -> None:
    known = ("dc", "ac", *WAVES)
    close = nearest(token.low, known)
    fail("P041", f"{token.text} is no wave form", token.span, label="not supported",
         notes=[f"did you mean {close[0].upper()}?"] if close else [],
         help=f"sources have {', '.join(w.upper() for w in known)}")  # fmt: skip


def _wave(scope: Scope, element: Element, word: Token, words: list[Token]) -> Component:
    spice = package("electrical.spice")

    values = [scope.value(value_of(t)) for t in words if t.kind != "mark"]
    letter, wave = element.letter, word.low
    cls = getattr(spice, f"{letter}_{wave}")
    if wave == "pwl":
        return cast(Component, cls(table=_points(word, values)))
    names = [n.format(letter) for n in WAVES[wave]]
    if len(values) < 2:
        fail("P040", f"{word.text} needs two values at least", word.span,
             help=f"write {word.low}({' '.join(names)})")  # fmt: skip
    for extra in values[len(names) :]:
        if extra.number:
            fail("P041", f"{word.text} with more than {len(names)} values", word.span,
                 label="not supported",
                 help=f"its values are {' '.join(names)}; a phase can be a delay TD")  # fmt: skip
    given: dict[str, Any] = {n: v.given for n, v in zip(names, values, strict=False)}
    numbers = {n: v.number for n, v in zip(names, values, strict=False)}
    for name, value in _defaults(scope, wave, word).items():
        if not numbers.get(name):
            given[name] = value
    if wave == "exp" and not numbers.get("TD2"):
        given["TD2"] = given["TD1"] + _step(scope, word)
    given = {n: v for n, v in given.items() if not (isinstance(v, float) and math.isinf(v))}
    return cast(Component, cls(**given))


def _defaults(scope: Scope, wave: str, word: Token) -> dict[str, Any]:
    """Return what SPICE takes instead of values that are missing or zero."""
    if wave == "pulse":
        step = _step(scope, word)
        return {"TR": step, "TF": step, "PW": math.inf, "PER": math.inf}
    if wave == "exp":
        step = _step(scope, word)
        return {"TD1": step, "TAU1": step, "TAU2": step}
    stop = _transient(scope, 1)
    if wave == "sin":
        return {"FREQ": 1.0 / stop} if stop else {}
    return {"FC": 1.0 / stop, "FS": 1.0 / stop} if stop else {}


def _transient(scope: Scope, which: int) -> float:
    values = scope.netlist.transient
    return top_of(scope).value(values[which]).number if values else 0.0


def _step(scope: Scope, word: Token) -> float:
    """Return the time step, which SPICE takes for rise times that are missing."""
    return _transient(scope, 0)


def top_of(scope: Scope) -> Scope:
    """Return the whole circuit."""
    *_, top = scope.circuits()
    return top


def _points(word: Token, values: list[Value]) -> list[list[Any]]:
    if len(values) < 2 or len(values) % 2:
        fail("P040", "PWL needs pairs of a time and a value", word.span,
             help="write PWL(0 0 1m 5 2m 0)")  # fmt: skip
    pairs = [[values[k], values[k + 1]] for k in range(0, len(values), 2)]
    for before, after in pairwise(pairs):
        if after[0].number < before[0].number:
            fail("P040", "the times of PWL go back", word.span,
                 label=f"{after[0].number:g} after {before[0].number:g}",
                 help="give the points in the order of time")  # fmt: skip
    if len(pairs) == 1:
        pairs.append([pairs[0][0].map(lambda t: t + 1.0), pairs[0][1]])
    return [[time.given, value.given] for time, value in pairs]
