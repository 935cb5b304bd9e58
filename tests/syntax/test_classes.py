"""Classes, declarations, equations and statements: what the tree holds, and round trips."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from acausal.diagnostics import Span
from acausal.syntax import tree
from acausal.syntax.formatter import (
    format_class,
    format_equation,
    format_expression,
    format_file,
    format_modifier,
)
from acausal.syntax.parser import parse_file, parse_text

ROOT = Path(__file__).parents[2]

EVERYTHING = """
within a.b;
import electrical.*;
import X = a.b.C;
import a.b.{C, D};
import q.r.S;

connector Pin "electrical cut"
  across  Voltage v;
  through Current i "positive " + "into the component";
  flow Real q;
end Pin;
type Voltage = Real(unit = "V", final quantity = "x");
type Vector = Real[3] "in space";
connector Input = input Real;
type E = enumeration(a "first", b, c) "kinds";
encapsulated package P
  model Inner end Inner;
end P;
pure function f
  input Real x; output Real y; protected Real z = 3;
algorithm
  y := x^2;
  (a, , b) := g(x, n=3);
  for i in 1:3, j loop y := y + i; end for;
  while y > 3 loop y := y - 1; if y < 3 then break; else return; end if; end while;
  when y > 3 then y := 1; elsewhen y < 2 then y := 2; end when;
  assert(x > 0, "bad\\n");
end f;
function g external "C" y = g(x); end g;
partial model OnePort
  extends Base(x(start = 1), redeclare model Z = Y);
  import Local = a.b;
  Pin p, n;
  Voltage v; Current i "d", j;
  Real[3] x[2](each start = 1, final k(min=2)=3) = fill(0, 2, 3) if use and not no
    annotation(Evaluate=true);
  replaceable package M = Foo constrainedby Bar;
  redeclare parameter Real 'x y' = -2^3*4;
  R r(redeclare model Z = Y(q=2), redeclare Real x = 2, k.m = 10 [kOhm], z=5[W/(m2.K)]);
  Real through;
protected
  outer World world;
  extends Hidden;
  Real x(start=0, fixed=true);
initial equation
  x = 0;
equation
  v = p.v - n.v "desc";
  connect(a.p, b[1].n, c[end-1, :].q);
  initial() = true;
  der(x) = if a then b elseif c then d else -e;
  (if a then b else c) = 0;
  (a, , b) = f(x);
  assert(true, "x");
  for i in 1:2:n loop
    connect(a[i], b[i + 1]);
    for j loop end for;
  end for;
  if x then y = 2; elseif z then y=3; else y = 4; end if;
  when {initial(), sample(0, 1)} then reinit(x, 3); elsewhen b then k = pre(k) + 1; end when;
initial algorithm
  k := 3;
algorithm
  k := 4;
algorithm
  k := 5;
equation
  z = 1;
  annotation(experiment(StopTime = 0.1));
end OnePort;
"""


def without_spans(node: Any) -> Any:
    if is_dataclass(node):
        values = [without_spans(getattr(node, f.name)) for f in fields(node) if f.name != "span"]
        return (type(node).__name__, *values)
    if isinstance(node, tuple):
        return tuple(without_spans(item) for item in node)
    return node


@pytest.fixture(scope="module")
def everything() -> tree.File:
    return parse_text(EVERYTHING, "everything.acm")


def model(file: tree.File, name: str) -> tree.ClassDefinition:
    return next(c for c in file.classes if c.name == name)


def test_round_trip_of_everything(everything: tree.File) -> None:
    text = format_file(everything)
    assert without_spans(parse_text(text, "again")) == without_spans(everything)
    assert format_file(parse_text(text, "again")) == text


@pytest.mark.parametrize(
    "path",
    sorted((ROOT / "library").rglob("*.acm")) + sorted((ROOT / "examples").rglob("*.acm")),
    ids=lambda path: path.stem,
)
def test_round_trip_of_the_library_and_examples(path: Path) -> None:
    file = parse_file(path)
    assert without_spans(parse_text(format_file(file), "again")) == without_spans(file)


def test_head_of_the_file(everything: tree.File) -> None:
    assert everything.within == ("a", "b")
    assert [(i.path, i.alias, i.wildcard, i.names) for i in everything.imports] == [
        (("electrical",), None, True, ()),
        (("a", "b", "C"), "X", False, ()),
        (("a", "b"), None, False, ("C", "D")),
        (("q", "r", "S"), None, False, ()),
    ]
    assert [(c.kind, c.name, c.partial, c.prefixes) for c in everything.classes] == [
        ("connector", "Pin", False, ()),
        ("type", "Voltage", False, ()),
        ("type", "Vector", False, ()),
        ("connector", "Input", False, ()),
        ("type", "E", False, ()),
        ("package", "P", False, ("encapsulated",)),
        ("function", "f", False, ("pure",)),
        ("function", "g", False, ()),
        ("model", "OnePort", True, ()),
    ]


def test_flow_is_through(everything: tree.File) -> None:
    pin = model(everything, "Pin")
    assert [(c.name, c.prefixes) for c in pin.components] == [
        ("v", ("across",)),
        ("i", ("through",)),
        ("q", ("through",)),
    ]
    assert pin.components[1].description == "positive into the component"


def test_short_classes(everything: tree.File) -> None:
    voltage = model(everything, "Voltage")
    assert str(voltage.alias) == "Real"
    assert [format_modifier(m) for m in voltage.alias_modifiers] == [
        'unit = "V"',
        'final quantity = "x"',
    ]
    vector = model(everything, "Vector")
    assert [format_expression(d) for d in vector.alias_dimensions] == ["3"]
    assert vector.description == "in space"
    assert model(everything, "Input").alias_prefixes == ("input",)
    kinds = model(everything, "E")
    assert kinds.enumeration == (("a", "first"), ("b", ""), ("c", ""))
    assert kinds.alias is None


def test_external_function(everything: tree.File) -> None:
    assert model(everything, "g").external
    assert not model(everything, "f").external


def test_components(everything: tree.File) -> None:
    port = model(everything, "OnePort")
    assert [(c.name, str(c.type_name), c.public) for c in port.components] == [
        ("p", "Pin", True),
        ("n", "Pin", True),
        ("v", "Voltage", True),
        ("i", "Current", True),
        ("j", "Current", True),
        ("x", "Real", True),
        ("'x y'", "Real", True),
        ("r", "R", True),
        ("through", "Real", True),
        ("world", "World", False),
        ("x", "Real", False),
    ]
    x = port.components[5]
    assert [format_expression(d) for d in x.dimensions] == ["2", "3"]  # of the name, of the type
    assert [format_modifier(m) for m in x.modifiers] == ["each start = 1", "final k(min = 2) = 3"]
    assert x.value is not None
    assert format_expression(x.value) == "fill(0, 2, 3)"
    assert x.condition is not None
    assert format_expression(x.condition) == "use and not no"
    assert x.annotation is not None
    assert port.components[3].description == "d"
    assert port.components[4].description == ""
    assert [(str(e.base), e.public) for e in port.extends] == [("Base", True), ("Hidden", False)]


def test_modifiers(everything: tree.File) -> None:
    r = model(everything, "OnePort").components[7]
    redeclared_class, redeclared, dotted, unit = r.modifiers
    assert isinstance(redeclared_class.redeclaration, tree.ClassDefinition)
    assert redeclared_class.name == ("Z",)
    assert isinstance(redeclared.redeclaration, tree.ComponentDeclaration)
    assert redeclared.redeclaration.prefixes == ("redeclare",)
    assert dotted.name == ("k", "m")
    assert isinstance(unit.value, tree.NumberLiteral)
    assert unit.value.unit == "W/(m2.K)"


def test_sections(everything: tree.File) -> None:
    port = model(everything, "OnePort")
    assert len(port.equations) == 11  # of both equation sections
    assert [format_equation(e) for e in port.initial_equations] == ["x = 0"]
    assert [len(section) for section in port.algorithms] == [1, 1]
    assert [len(section) for section in port.initial_algorithms] == [1]
    assert port.annotation is not None
    assert port.annotation.arguments[0].nested[0].name == ("StopTime",)


def test_equations(everything: tree.File) -> None:
    equations = model(everything, "OnePort").equations
    assert [format_equation(e) for e in equations[:7]] == [
        'v = p.v - n.v "desc"',
        "connect(a.p, b[1].n, c[end - 1, :].q)",
        "initial() = true",
        "der(x) = if a then b elseif c then d else -e",
        "(if a then b else c) = 0",
        "(a, , b) = f(x)",
        'assert(true, "x")',
    ]
    assert [type(e).__name__ for e in equations[7:10]] == [
        "ForEquation",
        "IfEquation",
        "WhenEquation",
    ]
    loop = equations[7]
    assert isinstance(loop, tree.ForEquation)
    assert format_equation(loop).splitlines() == [
        "for i in 1:2:n loop",
        "  connect(a[i], b[i + 1]);",
        "  for j loop",
        "  end for;",
        "end for",
    ]
    choice = equations[8]
    assert isinstance(choice, tree.IfEquation)
    assert (len(choice.branches), len(choice.otherwise)) == (2, 1)


def test_statements(everything: tree.File) -> None:
    (body,) = model(everything, "f").algorithms
    assert [type(s).__name__ for s in body] == [
        "Assignment",
        "Assignment",
        "ForStatement",
        "WhileStatement",
        "WhenStatement",
        "CallStatement",
    ]
    several = body[1]
    assert isinstance(several, tree.Assignment)
    assert isinstance(several.target, tree.TupleExpression)
    assert [e is None for e in several.target.elements] == [False, True, False]


def test_every_node_has_its_place(everything: tree.File) -> None:
    lines = EVERYTHING.split("\n")
    seen = 0
    stack: list[Any] = [everything]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            stack += item
        elif isinstance(item, tree.Node):
            seen += 1
            span = item.span
            assert span.source == "everything.acm"
            assert (span.line, span.column) < (span.end_line, span.end_column)
            stack += [getattr(item, f.name) for f in fields(item) if f.name != "span"]
            if isinstance(item, tree.ComponentDeclaration | tree.ClassDefinition | tree.NamePart):
                written = lines[span.line - 1][span.column - 1 :]
                assert written.startswith(item.name)
    assert seen > 300


def test_places_of_equations() -> None:
    file = parse_text('model M\nequation\n  a.b = c +\n    d "text";\nend M;', "m")
    equation = file.classes[0].equations[0]
    assert equation.span == Span("m", 3, 3, 4, 6)
    assert equation.description == "text"


def test_keywords_only_in_their_place() -> None:
    file = parse_text("model M Real across; Real through(start = 1); Real iff, ende; end M;", "m")
    assert [c.name for c in file.classes[0].components] == ["across", "through", "iff", "ende"]


def test_a_class_reads_well() -> None:
    text = (
        'model RLC "series circuit"\n'
        '  parameter Resistance R(min = 0) = 100[Ohm] "load";\n'
        "  Inductor l(L = 10[mH]);\n"
        "equation\n"
        "  connect(l.p, r.n);\n"
        "  annotation(experiment(StopTime = 0.1));\n"
        "end RLC;\n"
    )
    assert format_class(parse_text(text, "x").classes[0]) == text
