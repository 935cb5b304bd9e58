"""Elements without model cards: passive ones, couplings, controlled sources."""

from __future__ import annotations

from typing import Any

from acausal.compose.component import Component
from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.packages import package
from acausal.netlists.spice.cards import Element
from acausal.netlists.spice.expressions import value_of
from acausal.netlists.spice.lines import Token
from acausal.netlists.spice.scope import Scope, Value, constant

_USAGE = {
    "R": "R1 a b 1k", "L": "L1 a b 1m", "C": "C1 a b 1u", "K": "K1 L1 L2 0.9", "V": "V1 a b 5",
    "I": "I1 a b 1m", "E": "E1 out 0 in 0 10", "G": "G1 out 0 in 0 1m", "F": "F1 out 0 V1 10",
    "H": "H1 out 0 V1 100", "X": "X1 a b circuit",
}  # fmt: skip


def incomplete(element: Element) -> Any:
    """Refuse an element without enough words.

    Raises:
        AcausalError: ``P040``.
    """
    return fail("P040", f"{element.name.text} is incomplete", element.span,
                help=f"write {_USAGE[element.letter]}")  # fmt: skip


def _only(element: Element, known: tuple[str, ...]) -> None:
    for key, (token, _) in element.options.items():
        if key not in known:
            close = nearest(key, known)
            fail("N103", f"{element.name.text} has nothing called {token.text}", token.span,
                 notes=[f"did you mean {close[0]}?"] if close else [],
                 help=f"it takes {', '.join(known)}")  # fmt: skip


def passive(scope: Scope, element: Element, start: Value | None) -> Component:
    """Return a resistor, capacitor or inductor.

    Args:
        scope: The circuit.
        element: The card.
        start: Voltage at the start that ``.ic`` gives a capacitor.

    Raises:
        AcausalError: ``P040``, ``P041``, ``N103``.
    """
    spice = package("electrical.spice")

    letter = element.letter
    key = letter.lower()
    words = list(element.words[2:])
    _only(element, (key, "ic", "m", "tc1", "tc2", "temp", "dtemp", "scale", "ac"))
    if letter != "R" and "temp" in element.options:
        fail("N103", f"{element.name.text} depends on no temperature",
             element.options["temp"][0].span, help="leave it out")  # fmt: skip
    if key in element.options:
        value = scope.value(element.options[key][1])
    elif words:
        value = scope.value(value_of(words.pop(0)))
    else:
        incomplete(element)
    if words and words[0].low != "ic":
        fail("P041", f"{words[0].text} behind the value of {element.name.text}", words[0].span,
             label="not supported",
             help="models of R, L and C are not supported; give the value")  # fmt: skip
    options = {k: scope.value(v) for k, (_, v) in element.options.items()}
    if "dtemp" in options or ("ac" in options and letter != "R"):
        fail("P041", "dtemp and ac", element.span, label="not supported", help="leave them out")
    given = value.given
    if "scale" in options:
        given = given * options["scale"].given
    if "m" in options:
        several = options["m"].given
        given = given * several if letter == "C" else given / several
    if letter == "R" and ("tc1" in options or "tc2" in options):
        given = _warmed(scope, given, options)
    if letter == "R":
        return _made(spice.R_Resistor(R=given))
    modifiers: dict[str, Any] = {letter: given}
    if scope.netlist.uic:
        modifiers["UIC"] = True
        initial = options.get("ic", start)
        if initial is not None and not (
            isinstance(initial.given, int | float) and initial.number == 0
        ):
            modifiers["IC"] = initial.given
    elif start is not None:
        modifiers |= {"UIC": True, "IC": start.given}
    return _made((spice.C_Capacitor if letter == "C" else spice.L_Inductor)(**modifiers))


def _warmed(scope: Scope, given: Any, options: dict[str, Value]) -> Any:
    """Return a resistance at its temperature."""
    netlist = scope.netlist
    nominal = 27.0 if netlist.nominal is None else scope.value(netlist.nominal).given
    temperature = 27.0 if netlist.temperature is None else scope.value(netlist.temperature).given
    if "temp" in options:
        temperature = options["temp"].given
    above = temperature - nominal
    first = options["tc1"].given if "tc1" in options else 0.0
    second = options["tc2"].given if "tc2" in options else 0.0
    return given * (1 + first * above + second * above**2)


def _made(part: Any) -> Component:
    found: Component = part
    return found


def controlled(
    scope: Scope, element: Element
) -> tuple[Component, list[tuple[str, Token]], Token | None]:
    """Return a controlled source, its cuts with their nodes, and the source whose current it reads.

    Raises:
        AcausalError: ``P040``, ``P041``.
    """
    spice = package("electrical.spice")

    letter = element.letter
    words = list(element.words)
    _only(element, ())
    if len(words) < 4:
        incomplete(element)
    output = [("p2", words[0]), ("n2", words[1])]
    rest = words[2:]
    polynomial = rest[0].low == "poly"
    if polynomial:
        if [t.text for t in rest[1:4]] != ["(", "1", ")"]:
            fail("P041", "POLY of several variables", rest[0].span, label="not supported",
                 help="POLY(1) is; add several sources in series or in parallel")  # fmt: skip
        rest = rest[4:]
    reads: Token | None = None
    if letter in "EG":
        if len(rest) < 3:
            incomplete(element)
        cuts = [("p1", rest[0]), ("n1", rest[1]), *output]
        rest = rest[2:]
    else:
        if len(rest) < 2:
            incomplete(element)
        reads, cuts, rest = rest[0], output, rest[1:]
    values = [scope.value(value_of(t)) for t in rest]
    if polynomial:
        return _polynomial(letter, values, element), cuts, reads
    if len(values) != 1:
        fail("P040", f"{element.name.text} has more than one gain", element.span,
             help=f"write {_USAGE[letter]}")  # fmt: skip
    cls, name = {
        "E": (spice.E_VCV, "gain"), "F": (spice.F_CCC, "gain"),
        "G": (spice.G_VCC, "transConductance"), "H": (spice.H_CCV, "transResistance"),
    }[letter]  # fmt: skip
    return _made(cls(**{name: values[0].given})), cuts, reads


def _polynomial(letter: str, values: list[Value], element: Element) -> Component:
    """Return a source whose output is a polynomial of what controls it.

    A single coefficient is that of the linear term, as in SPICE.
    """
    from acausal.netlists.spice.polynomials import polynomial_class

    if not values:
        incomplete(element)
    if len(values) == 1:
        values = [constant(0.0), values[0]]
    return _made(polynomial_class(letter, len(values))(c=[v.given for v in values]))
