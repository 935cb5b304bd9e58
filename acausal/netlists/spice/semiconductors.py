"""Diodes and transistors: model cards become records of the library."""

from __future__ import annotations

from typing import Any

from acausal.compose.component import Component, ComponentType
from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.packages import package
from acausal.netlists.spice.cards import Element, ModelCard, warning
from acausal.netlists.spice.expressions import Expression, names_in, value_of
from acausal.netlists.spice.lines import Token
from acausal.netlists.spice.scope import Scope, Value

#: Kind of a model card -> class of the library, its record, and the name of that parameter.
KINDS = {
    "d": ("D_DIODE", "ModelcardDIODE", "modelcarddiode"),
    "npn": ("Q_NPNBJT", "ModelcardBJT", "modelcard"),
    "pnp": ("Q_PNPBJT", "ModelcardBJT", "modelcard"),
    "nmos": ("M_NMOS", "ModelcardMOS", "modelcard"),
    "pmos": ("M_PMOS", "ModelcardMOS", "modelcard"),
}
_KINDS_OF = {"D": ("d",), "Q": ("npn", "pnp"), "M": ("nmos", "pmos")}

#: Other names of parameters.
_ALIASES = {
    "D": {"cj0": "cjo", "cj": "cjo", "pb": "vj", "mj": "m", "tref": "tnom", "jo": "is", "js": "is"},
    "Q": {"va": "vaf", "vb": "var", "ik": "ikf", "pe": "vje", "me": "mje", "pc": "vjc",
          "mc": "mjc", "jle": "ise", "jlc": "isc", "tref": "tnom"},
    "M": {"vt0": "vto"},
}  # fmt: skip

#: Noise, limits and labels, which no trajectory shows.
_WITHOUT_EFFECT = frozenset((
    "kf", "af", "level", "mfg", "mfr", "vendor", "type", "icrating", "vceo", "iave", "vpk",
    "nlev", "gdsnoi", "ioffs",
))  # fmt: skip

#: Parameters that SPICE has and the library's laws have not, with the value that makes them vanish.
_MISSING: dict[str, dict[str, float | None]] = {
    "D": {"isr": 0, "nr": 2, "ikf": 0, "ikr": 0, "trs1": 0, "trs2": 0, "tbv1": 0, "nbv": 1,
          "jsw": 0, "cjsw": 0, "php": 1, "mjsw": 0.33, "fcs": 0.5, "cta": 0, "tt1": 0, "tt2": 0,
          "tm1": 0, "tm2": 0, "tvj": 0, "ns": 1, "area": 1, "pj": 0, "rsw": 0},
    "Q": {"irb": 0, "rbm": None, "xtf": 0, "vtf": 0, "itf": 0, "ptf": 0, "xcjc": 1, "cjs": 0,
          "ccs": 0, "vjs": 0.75, "ps": 0.75, "mjs": 0, "ms": 0, "iss": 0, "ns": 1, "nk": 0.5,
          "nkf": 0.5, "rco": 0, "vo": 10, "gamma": 0, "qco": 0, "xcjc2": 1, "tre1": 0, "tre2": 0,
          "trb1": 0, "trb2": 0, "trc1": 0, "trc2": 0, "subs": 1, "quasimod": 0},
    "M": {"cjsw": 0, "mjsw": 0.33, "js": 0, "jssw": 0, "nsub": 0, "nss": 0, "nfs": 0, "tpg": 1,
          "xj": 0, "tox": None, "ucrit": 0, "uexp": 0, "utra": 0, "vmax": 0, "neff": 1,
          "delta": 0, "theta": 0, "eta": 0, "kappa": 0.2, "tnom": 27, "n": 1, "u0": 600,
          "wd": 0, "xl": 0, "xw": 0},
}  # fmt: skip


def device(scope: Scope, element: Element) -> tuple[Component, list[tuple[str, Token]]]:
    """Return the component of a diode or transistor, and its cuts with their nodes.

    Raises:
        AcausalError: ``P040``, ``P041``, ``N122``.
    """
    nodes, model, rest = _words(scope, element)
    card = scope.find_model(model)
    letter = element.letter
    if card.kind.low not in _KINDS_OF[letter]:
        fail("P041", f"{model.text} is a model of kind {card.kind.text}", model.span,
             label=f"{element.name.text} needs {' or '.join(_KINDS_OF[letter]).upper()}",
             help="name another model; " + ", ".join(KINDS).upper() + " are supported")  # fmt: skip
    given, area = _instance(scope, element, rest)
    changes = _per_instance(scope, element, card, area)
    cls = _card_class(scope, card, letter, changes)
    if changes:
        given[KINDS[card.kind.low][2]] = changes
    part: Component = cls(**given)
    cuts = {"D": ("p", "n"), "Q": ("C", "B", "E"), "M": ("D", "G", "S", "B")}[letter]
    return part, list(zip(cuts, nodes, strict=False))


def _words(scope: Scope, element: Element) -> tuple[tuple[Token, ...], Token, list[Token]]:
    """Return nodes, name of the model, and what follows it."""
    counts = {"D": (2,), "Q": (3, 4), "M": (4,)}[element.letter]
    words = element.words
    for count in counts:
        if len(words) > count and (count == counts[-1] or scope.has_model(words[count])):
            return words[:count], words[count], list(words[count + 1 :])
    if element.letter == "Q" and len(words) == 4:
        return words[:3], words[3], []
    usage = {"D": "D1 a c model", "Q": "Q1 c b e model", "M": "M1 d g s b model L=1u W=10u"}
    return fail("P040", f"{element.name.text} is incomplete", element.span,
                help=f"write {usage[element.letter]}")  # fmt: skip


def _instance(
    scope: Scope, element: Element, rest: list[Token]
) -> tuple[dict[str, Any], Value | None]:
    """Return modifiers of a device, and how much wider it is than its model card."""
    letter = element.letter
    given: dict[str, Any] = {}
    options = {k: scope.value(v) for k, (_, v) in element.options.items() if k != "ic"}
    width: Value | None = None
    for word in rest:
        if word.low in ("off", "on"):
            continue  # a guess
        if letter == "M" or width is not None:
            fail("P040", f"{word.text} has no meaning there", word.span, help="write name=value")
        width = scope.value(value_of(word))
    width = options.pop("area", width)
    several = options.pop("m", None)
    if letter == "M":
        for key in ("l", "w"):
            if key in options:
                given[key.upper()] = options.pop(key).given
        if several is not None:
            given["W"] = given.get("W", 1e-4) * several.given
    elif several is not None:
        width = several if width is None else _product(width, several)
    if width is not None and letter != "M":
        given["AREA"] = width.given
    temperature = options.pop("temp", None)
    if temperature is not None:
        given["TEMP"] = temperature.given
    elif scope.netlist.temperature is not None:
        given["TEMP"] = scope.value(scope.netlist.temperature).given
    if "ic" in element.options and scope.netlist.uic:
        if letter == "D":
            given["IC"] = scope.value(element.options["ic"][1]).given
        else:
            scope.warn(warning("P043", f"ic of {element.name.text} has no effect",
                               element.options["ic"][0].span,
                               "give voltages of capacitors instead"))  # fmt: skip
    if letter == "D" and scope.netlist.uic:
        given["UIC"] = True
    for key in ("ad", "as", "pd", "ps", "nrd", "nrs"):
        if letter == "M":
            options.pop(key, None)
    for key in options:
        token = element.options[key][0]
        known = ["area", "ic", "temp", "m"] + ["l", "w", "ad", "as", "nrd", "nrs"] * (letter == "M")
        close = nearest(key, known)
        fail("N103", f"{element.name.text} has nothing called {token.text}", token.span,
             notes=[f"did you mean {close[0]}?"] if close else [],
             help=f"it takes {', '.join(known)}")  # fmt: skip
    return given, several


def _product(first: Value, second: Value) -> Value:
    return Value(first.number * second.number, first.given * second.given)


def _per_instance(
    scope: Scope, element: Element, card: ModelCard, several: Value | None
) -> dict[str, Any]:
    """Return values of the card of a MOS transistor that depend on its areas."""
    if element.letter != "M":
        return {}
    changes: dict[str, Any] = {}
    own = {k: scope.value(v) for k, (_, v) in element.options.items() if k != "ic"}
    known = {k: scope.value(v) for k, (_, v) in card.parameters.items() if k != "mfg"}
    for capacitance, area in (("cbd", "ad"), ("cbs", "as")):
        if capacitance not in known and "cj" in known and area in own:
            changes[capacitance.upper()] = _product(known["cj"], own[area]).given
    for resistance, squares in (("rd", "nrd"), ("rs", "nrs")):
        if resistance not in known and "rsh" in known and squares in own:
            changes[resistance.upper()] = _product(known["rsh"], own[squares]).given
    if several is not None:
        for name in ("cbd", "cbs", "is", "cgbo", "rd", "rs"):
            default = 1e-14 if name == "is" else 0.0
            value = changes.get(name.upper(), known[name].given if name in known else default)
            changes[name.upper()] = (
                value / several.given if name in ("rd", "rs") else value * several.given
            )
    return changes


def _card_class(scope: Scope, card: ModelCard, letter: str, changes: dict[str, Any]) -> Any:
    """Return the class of all devices with a model card.

    A card of plain numbers is a class of its own, as people write it; one with parameters of the
    circuit cannot be, so each device gets the values.
    """
    spice = package("electrical.spice")

    cls, record, name = KINDS[card.kind.low]
    base = getattr(spice, cls)
    fixed: dict[str, Any] = {}
    for field, (_, value) in _fields(scope, card, letter, record).items():
        if names_in(value):
            changes.setdefault(field, scope.value(value).given)
        else:
            fixed[field] = scope.value(value).number
    if letter == "M" and "KP" not in fixed and "KP" not in changes and "tox" in card.parameters:
        changes["KP"] = _transconductance(scope, card)
    if not fixed:
        return base
    key = (id(card), *sorted(fixed.items()))
    found = scope.classes.get(key)
    if found is None:
        from acausal.netlists.identifiers import identifier

        title = identifier(card.name.text, "model_")
        found = scope.classes[key] = ComponentType(
            title[0].upper() + title[1:],
            (base,),
            {"__module__": "acausal_netlist", "__doc__": f".model {card.name.text}"},
            **{name: fixed},
        )
    return found


def _transconductance(scope: Scope, card: ModelCard) -> Any:
    """Return KP of mobility and oxide: ``UO*eps/TOX``, UO in cm2/Vs."""
    known = {k: scope.value(v) for k, (_, v) in card.parameters.items()}
    mobility = known.get("uo") or known.get("u0") or Value(600.0, 600.0)
    return mobility.given * 1e-4 * 3.9 * 8.854187817e-12 / known["tox"].given


def _fields(
    scope: Scope, card: ModelCard, letter: str, record: str
) -> dict[str, tuple[Token, Expression]]:
    """Return the fields of the record that a card gives.

    Raises:
        AcausalError: ``N103`` for parameters that there are not, ``P041`` for other levels.
    """
    spice = package("electrical.spice")

    names = {n.lower(): n for n in getattr(spice, record)()._kind.names()}
    used = {"M": {"cj", "rsh", "uo", "u0"}}.get(letter, set())
    found: dict[str, tuple[Token, Expression]] = {}
    if letter in "DQ" and scope.netlist.nominal is not None and "tnom" not in card.parameters:
        found["TNOM"] = (card.name, scope.netlist.nominal)
    ignored = []
    for key, (token, value) in card.parameters.items():
        name = _ALIASES[letter].get(key, key)
        if key == "level" and scope.value(value).number != 1:
            fail("P041", f"level {scope.value(value).number:g} of {card.name.text}", token.span,
                 label="not supported", help="level 1 is")  # fmt: skip
        if name in names:
            if name not in _INFINITE or scope.value(value).number < _HUGE:
                found[names[name]] = (token, value)
        elif name in _MISSING[letter] and name not in used:
            if scope.value(value).number != _MISSING[letter][name]:
                ignored.append(token)
        elif name not in _WITHOUT_EFFECT and name not in used:
            close = nearest(name, names)
            fail("N103", f"a model of kind {card.kind.text} has no parameter {token.text}",
                 token.span, notes=[f"did you mean {close[0].upper()}?"] if close else [],
                 help=f"it has {', '.join(names.values())}")  # fmt: skip
    if ignored:
        scope.warn(warning(
            "P043", f"{', '.join(t.text for t in ignored)} of {card.name.text}: the library's "
            "model has no such parameter", ignored[0].span,
            "the simulation goes without the effect",
        ))  # fmt: skip
    return found


#: Where SPICE means infinity by large numbers and the library by zero.
_INFINITE = ("vaf", "var", "ikf", "ikr")
_HUGE = 1e30
