"""Cards of a netlist as records, sorted into the circuit and its subcircuits."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from acausal.diagnostics import Diagnostic, Label, Severity, Span, fail
from acausal.diagnostics.suggest import nearest
from acausal.netlists.spice.expressions import Expression, Number, parse, value_of
from acausal.netlists.spice.lines import Line, Token, read_text, split_lines

#: Letters of elements that are understood.
ELEMENTS = "RLCKVIEFGHDQMX"
_DOTS = (".model", ".subckt", ".ends", ".param", ".include", ".tran", ".ic", ".global", ".temp",
         ".options", ".end")  # fmt: skip
#: Cards about output and other analyses, which change nothing in the circuit.
_OUTPUT = (".print", ".plot", ".probe", ".save", ".op", ".four", ".meas", ".measure", ".width",
           ".title", ".nodeset")  # fmt: skip
_ANALYSES = (".ac", ".dc", ".noise", ".tf", ".sens", ".pz", ".disto", ".pss", ".sp", ".step")
#: Options that tell SPICE how to compute, and nothing about the circuit.
_NUMERICAL = (
    "abstol", "reltol", "vntol", "chgtol", "gmin", "gminsteps", "itl1", "itl2", "itl3", "itl4",
    "itl5", "itl6", "method", "maxord", "trtol", "pivtol", "pivrel", "rshunt", "acct", "list",
    "nomod", "nopage", "node", "noacct", "opts", "noopalter", "trytocompact", "srcsteps", "numdgt",
    "savecurrents", "post", "ingold", "limpts", "lvlcod", "lvltim", "interp", "filetype",
    "klu", "sparse", "xmu", "noinit", "autostop", "cptime", "width", "brief", "warn",
)  # fmt: skip
_MOST_INCLUDES = 50


@dataclass(frozen=True, slots=True)
class Element:
    """An element: its name, the words behind it, and what is given as ``key=value``."""

    name: Token
    words: tuple[Token, ...]
    options: dict[str, tuple[Token, Expression]]
    span: Span

    @property
    def letter(self) -> str:
        """Its kind."""
        return self.name.text[0].upper()


@dataclass(frozen=True, slots=True)
class ModelCard:
    """``.model``: a kind of device and its parameters."""

    name: Token
    kind: Token
    parameters: dict[str, tuple[Token, Expression]]
    span: Span


@dataclass(slots=True)
class Circuit:
    """A subcircuit, or the whole netlist.

    Attributes:
        name: Its name.
        ports: Its nodes.
        defaults: Values of parameters of a subcircuit, which an instance may change.
        parameters: ``.param``, by name without capitals.
        elements: Its elements in order.
        models: ``.model`` by name.
        circuits: Subcircuits defined in it, by name.
        span: The place.
    """

    name: str
    ports: tuple[Token, ...]
    span: Span
    defaults: dict[str, tuple[Token, Expression]] = field(default_factory=dict)
    parameters: dict[str, tuple[Token, Expression]] = field(default_factory=dict)
    elements: list[Element] = field(default_factory=list)
    models: dict[str, ModelCard] = field(default_factory=dict)
    circuits: dict[str, Circuit] = field(default_factory=dict)
    names: dict[str, Span] = field(default_factory=dict)


@dataclass(slots=True)
class Netlist:
    """What a netlist says.

    Attributes:
        title: Its first line.
        circuit: Its elements and definitions.
        transient: ``.tran``: step, stop and perhaps start and largest step.
        uic: Whether the start values are used instead of the operating point.
        start: ``.ic``: nodes and their voltages.
        globals: Nodes that all subcircuits share.
        temperature: ``.temp`` or option ``temp``, degrees Celsius.
        nominal: Option ``tnom``.
        warnings: What was noticed and has no effect here.
    """

    title: str
    circuit: Circuit
    transient: tuple[Expression, ...] = ()
    uic: bool = False
    start: list[tuple[Token, Expression]] = field(default_factory=list)
    globals: tuple[str, ...] = ()
    temperature: Expression | None = None
    nominal: Expression | None = None
    warnings: list[Diagnostic] = field(default_factory=list)


def warning(code: str, message: str, span: Span, help: str) -> Diagnostic:  # noqa: A002
    """Return a warning."""
    return Diagnostic(code, message, span, help=help, severity=Severity.WARNING)


def read_cards(text: str, path: Path) -> Netlist:
    """Return what a netlist says.

    Raises:
        AcausalError: ``P040``, ``P041``, ``P042``, ``F101``, ``N105``.
    """
    return _Reader(text, path).netlist


class _Reader:
    def __init__(self, text: str, path: Path) -> None:
        title, lines = split_lines(text, str(path), True)
        self.netlist = Netlist(title, Circuit("", (), Span(str(path), 1, 1, 1, len(title) + 1)))
        self.path = path
        self.open: list[Circuit] = [self.netlist.circuit]
        self.control = False
        self.included: tuple[Path, ...] = (path.resolve(),)
        self.count = 0
        self._check_title(title)
        self.read(lines)
        if len(self.open) > 1:
            fail("P040", f"subcircuit {self.open[-1].name} has no .ends", self.open[-1].span,
                 help=f"write .ends {self.open[-1].name} behind its last element")  # fmt: skip

    def _check_title(self, title: str) -> None:
        if re.match(rf"\.\w|[{ELEMENTS}]\d+\s+\S+\s+\S+\s+\S", title, re.IGNORECASE):
            self.warn("P043", "the first line is the title and no card", self.netlist.circuit.span,
                      "put a title before it")  # fmt: skip

    def warn(self, code: str, message: str, span: Span, help: str) -> None:  # noqa: A002
        self.netlist.warnings.append(warning(code, message, span, help))

    def read(self, lines: Sequence[Line]) -> None:
        for line in lines:
            key = line.key
            if self.control:
                self.control = key != ".endc"
            elif key[0] == ".":
                self.dot(line)
            elif key[0].upper() in ELEMENTS and line.tokens[0].kind == "word":
                self.element(line)
            else:
                fail("P041", f"there is no element with the letter {line.tokens[0].text[0]}",
                     line.span, label="not supported",
                     help=f"the letters {', '.join(ELEMENTS)} are understood; comments begin "
                     "with *")  # fmt: skip

    def element(self, line: Line) -> None:
        name = line.tokens[0]
        if name.low[0] in "eg":
            _refuse_functions(line)
        words, options = arguments(line.tokens[1:])
        known = self.open[-1].names
        if name.low in known:
            fail("N105", f"there are two elements {name.text}", name.span,
                 labels=[Label(known[name.low], "first here")],
                 help="names do not differ by capitals; rename one")  # fmt: skip
        known[name.low] = name.span
        self.open[-1].elements.append(Element(name, words, options, line.span))

    def dot(self, line: Line) -> None:
        key = {".inc": ".include", ".incl": ".include", ".opt": ".options", ".option": ".options",
               ".params": ".param"}.get(line.key, line.key)  # fmt: skip
        if key in _OUTPUT:
            return
        if key == ".control":
            self.control = True
            self.warn("P043", "commands between .control and .endc are not carried out",
                      line.span, "use acausal simulate, or Python")  # fmt: skip
            return
        if key in _ANALYSES:
            self.warn("P043", f"{line.tokens[0].text} is not carried out", line.span,
                      "the transient analysis .tran is")  # fmt: skip
            return
        if key not in _DOTS:
            close = nearest(key, _DOTS)
            fail(
                "P041",
                f"there is no card {line.tokens[0].text}",
                line.span,
                label="not supported",
                notes=[f"did you mean {close[0]}?"] if close else [],
                help=f"supported are {', '.join(_DOTS)}; {', '.join(_OUTPUT)} are skipped",
            )
        handler: Callable[[Line], None] = getattr(self, "_" + key[1:])
        handler(line)

    def _need(self, line: Line, count: int, usage: str) -> None:
        if len(line.tokens) <= count:
            fail("P040", f"{line.tokens[0].text} is incomplete", line.span, help=f"write {usage}")

    def _model(self, line: Line) -> None:
        self._need(line, 2, ".model name D(IS=1e-14)")
        name, kind = line.tokens[1:3]
        words, given = arguments(line.tokens[3:])
        if words:
            fail("P040", f"{words[0].text} is no parameter of the model", words[0].span,
                 help=f"write {words[0].text}=value")  # fmt: skip
        models = self.open[-1].models
        if name.low in models:
            fail(
                "N105",
                f"there are two models {name.text}",
                name.span,
                labels=[Label(models[name.low].span, "first here")],
                help="rename one",
            )
        models[name.low] = ModelCard(name, kind, given, line.span)

    def _subckt(self, line: Line) -> None:
        self._need(line, 1, ".subckt name node1 node2 gain=10")
        words, defaults = arguments(line.tokens[1:])
        ports = tuple(w for w in words[1:] if w.low != "params:")
        circuit = Circuit(words[0].text if words else "", ports, line.span, defaults)
        if not words:
            fail("P040", "a subcircuit has no name", line.span, help="write .subckt name nodes")
        seen: dict[str, Token] = {}
        for port in ports:
            if port.low in seen or port.low in ("0", "gnd"):
                fail("P040", f"node {port.text} cannot be a node of {circuit.name} "
                     f"{'twice' if port.low in seen else 'given by its name'}", port.span,
                     help="give every node its own name; 0 is ground everywhere")  # fmt: skip
            seen[port.low] = port
        known = self.open[-1].circuits
        if circuit.name.lower() in known:
            fail("N105", f"there are two subcircuits {circuit.name}", line.span,
                 labels=[Label(known[circuit.name.lower()].span, "first here")],
                 help="rename one")  # fmt: skip
        known[circuit.name.lower()] = circuit
        self.open.append(circuit)

    def _ends(self, line: Line) -> None:
        if len(self.open) == 1:
            fail("P040", ".ends closes nothing", line.span, help="remove it, or add its .subckt")
        if len(line.tokens) > 1 and line.tokens[1].low != self.open[-1].name.lower():
            fail("P040", f"{self.open[-1].name} is open, not {line.tokens[1].text}",
                 line.tokens[1].span, labels=[Label(self.open[-1].span, "opened here")],
                 help=f"write .ends {self.open[-1].name}")  # fmt: skip
        self.open.pop()

    def _param(self, line: Line) -> None:
        self._need(line, 3, ".param name=value")
        _, given = arguments(line.raw[1:], loose=True)
        for key, (token, value) in given.items():
            self.open[-1].parameters[key] = (token, value)

    def _include(self, line: Line) -> None:
        self._need(line, 1, '.include "file.lib"')
        name = line.tokens[1]
        relative = Path(name.text)
        if relative.is_absolute() or name.text.startswith("~"):
            fail("F107", f"{name.text} is no relative path", name.span,
                 help="name files relative to the netlist, so that it can be moved")  # fmt: skip
        path = Path(name.span.source).parent / relative
        self.count += 1
        if path.resolve() in self.included or self.count > _MOST_INCLUDES:
            fail("F107", f"{name.text} includes itself" if self.count <= _MOST_INCLUDES
                 else "too many files are included", name.span,
                 help="remove one .include of the circle")  # fmt: skip
        before = self.included
        self.included = (*before, path.resolve())
        _, lines = split_lines(read_text(path, name.span), str(path), False)
        self.read(lines)
        self.included = before

    def _tran(self, line: Line) -> None:
        words = [t for t in line.tokens[1:] if t.low != "uic"]
        if len(words) < 2:
            fail("P040", ".tran is incomplete", line.span,
                 help="write .tran step stop, for example .tran 1u 1m")  # fmt: skip
        if self.netlist.transient:
            self.warn("P043", "a second .tran replaces the first one", line.span, "remove one")
        self.netlist.transient = tuple(value_of(t) for t in words[:4])
        self.netlist.uic = len(words) != len(line.tokens) - 1

    def _ic(self, line: Line) -> None:
        tokens = line.tokens[1:]
        for at in range(0, len(tokens), 6):
            part = tokens[at : at + 6]
            if len(part) < 6 or [part[k].low for k in (0, 1, 3, 4)] != ["v", "(", ")", "="]:
                fail("P040", ".ic gives voltages of nodes", line.span, help="write .ic v(out)=5")
            self.netlist.start.append((part[2], value_of(part[5])))

    def _global(self, line: Line) -> None:
        self.netlist.globals += tuple(t.low for t in line.tokens[1:])

    def _temp(self, line: Line) -> None:
        self._need(line, 1, ".temp 27")
        self.netlist.temperature = value_of(line.tokens[1])

    def _options(self, line: Line) -> None:
        words, given = arguments(line.tokens[1:])
        for key, (token, value) in given.items():
            if key == "temp":
                self.netlist.temperature = value
            elif key == "tnom":
                self.netlist.nominal = value
            elif key not in _NUMERICAL:
                self._no_option(token)
        for word in words:
            if word.low not in _NUMERICAL:
                self._no_option(word)

    def _no_option(self, token: Token) -> None:
        self.warn(
            "P043",
            f"the option {token.text} has no effect",
            token.span,
            "temp and tnom are used; options about SPICE's own algorithms are skipped",
        )


def _refuse_functions(line: Line) -> None:
    """Refuse controlled sources that are more than linear, before their formulas are read.

    Raises:
        AcausalError: ``P041``.
    """
    for token in line.tokens[3:]:
        if token.low in ("value", "table", "laplace", "freq", "vol", "cur"):
            fail("P041", f"{token.text} in a controlled source", token.span,
                 label="not supported", help="linear sources and POLY(1) are")  # fmt: skip


def arguments(
    tokens: Sequence[Token], loose: bool = False
) -> tuple[tuple[Token, ...], dict[str, tuple[Token, Expression]]]:
    """Return the words of a card, and what it gives as ``key=value``.

    Brackets around all ``key=value`` are taken away; others stay among the words.

    Args:
        tokens: Behind the name.
        loose: Whether an expression may stand without braces, as in ``.param``.

    Raises:
        AcausalError: ``P040`` for ``=`` without a name or value, ``P042`` for wrong values.
    """
    words: list[Token] = []
    given: dict[str, tuple[Token, Expression]] = {}
    at = 0
    while at < len(tokens):
        token = tokens[at]
        if token.text == "=" and token.kind == "mark":
            fail("P040", "= has no name before it", token.span, help="write name=value")
        if at + 1 < len(tokens) and tokens[at + 1].text == "=" and token.kind == "word":
            last = at + 3
            if loose:
                while last < len(tokens) and not _begins(tokens, last):
                    last += 1
            value = tokens[at + 2 : last]
            while value and value[-1].text == ",":
                value = value[:-1]
            if not value or value[0].text in ("=", ")"):
                fail("P040", f"{token.text} has no value", token.span, help="write name=value")
            if token.low in given:
                fail("N105", f"{token.text} is given twice", token.span, help="remove one")
            if len(value) == 1:
                given[token.low] = (token, value_of(value[0]))
            else:
                text = " ".join(f"({t.text})" if t.kind == "expression" else t.text for t in value)
                given[token.low] = (token, parse(text, value[0].span))
            at = last
            continue
        if not (token.kind == "mark" and (given or token.text == ",")):
            words.append(token)
        at += 1
    if given and words and words[-1].text == "(":
        words.pop()
    return tuple(words), given


def _begins(tokens: Sequence[Token], at: int) -> bool:
    return at + 1 < len(tokens) and tokens[at + 1].text == "=" and tokens[at + 1].kind == "mark"


ZERO = Number(0.0)
