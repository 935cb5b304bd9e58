"""Syntax errors: code, line and column of each, and that every one has a way out."""

from __future__ import annotations

import pytest

from acausal.diagnostics import AcausalError, Diagnostic
from acausal.diagnostics.codes import CODES
from acausal.syntax.parser import parse_text


def refused(text: str) -> Diagnostic:
    with pytest.raises(AcausalError) as caught:
        parse_text(text, "x.acm")
    assert len(caught.value.diagnostics) == 1
    return caught.value.diagnostics[0]


def in_equations(line: str) -> str:
    return f"model M\nequation\n  {line}\nend M;\n"


def in_elements(line: str) -> str:
    return f"model M\n  {line}\nend M;\n"


CASES = [
    # missing semicolon: at the end of the line it belongs to
    ("model M\n  Real x\n  Real y;\nend M;", "P002", 2, 9),
    ("model M\n  Real x; Real z\nequation\n  x = 1;\nend M;", "P002", 2, 17),
    ("model M\nequation\n  x = 1\nend M;", "P002", 3, 8),
    ("model M\nequation\n  x = y\n  (a, b) = f(x);\nend M;", "P002", 3, 8),
    ("model M\nequation\n  x = y\n  -z = 3;\nend M;", "P002", 3, 8),
    ("model M\nequation\n  connect(a, b)\n  connect(c, d);\nend M;", "P002", 3, 16),
    ("model M\nend M", "P002", 2, 6),
    ("model M\nend M\nmodel N\nend N;", "P002", 2, 6),
    ("model M\n  import a.b\n  Real x;\nend M;", "P002", 2, 13),
    ("model M\n  extends A\n  Real x;\nend M;", "P002", 2, 12),
    ("model M\nequation\n  if a then\n    x = 1;\n  end if\n  y = 2;\nend M;", "P002", 5, 9),
    # blocks that are not closed
    ("model M\n  Real x;\n", "P003", 2, 10),
    ("model M\nequation\n  x = ", "P003", 3, 6),
    ("model M\nequation\n  x = 1;\n\nmodel N\nend N;", "P003", 6, 7),
    ("model M\nequation\n  for i in 1:3 loop\n    x = 1;\nend M;", "P003", 5, 1),
    ("model M\nequation\n  for i in 1:3 loop\n    x = 1;\n  end if;\nend M;", "P003", 5, 3),
    ("model M\nequation\n  if a then\n    x = 1;\nequation\n  y = 2;\nend M;", "P003", 5, 1),
    (
        "model M\nequation\n  if a then\n   x = 1;\n  else if b then\n   x = 2;\n  end if;\nend M;",
        "P003",
        8,
        1,
    ),
    # ends that do not fit
    ("model M\nend N;", "P004", 2, 5),
    ("package P\n  model M\n    Real x;\nend P;", "P004", 4, 5),
    ("model M\nend;", "P004", 2, 1),
    (in_equations("x = 1; end for;"), "P004", 3, 10),
    ("model M\nend M;\nend M;", "P004", 3, 1),
    # missing keywords
    (in_equations("if x > 3\n    y = 2;\n  end if;"), "P005", 3, 11),
    (in_equations("when x > 3 y = 2; end when;"), "P005", 3, 13),
    (in_equations("for i in 1:3\n    y[i] = 2;\n  end for;"), "P005", 3, 15),
    (in_equations("for i = 1:3 loop\n    y[i] = 2;\n  end for;"), "P005", 3, 9),
    (in_equations("y = if a then b;"), "P005", 3, 18),
    # assignment signs
    ("model M\nalgorithm\n  x = 3;\nend M;", "P006", 3, 5),
    ("model M\nalgorithm\n  x == 3;\nend M;", "P006", 3, 5),
    (in_equations("x := 3;"), "P006", 3, 5),
    (in_equations("der(x) := 3;"), "P006", 3, 10),
    # brackets
    (in_equations("x = (a + b;"), "P007", 3, 7),
    (in_equations("x = a + b);"), "P007", 3, 12),
    (in_equations("x = f(a, {b));"), "P007", 3, 14),
    (in_elements("Resistor r(R = 3;"), "P007", 2, 13),
    ("model M\n  Resistor r(R = 3\nequation\n  x = 1;\nend M;", "P007", 2, 13),
    # characters
    (in_equations("x = a # b;"), "P008", 3, 9),
    (in_equations("x = a − b;"), "P008", 3, 9),
    (in_equations("x = a != b;"), "P008", 3, 9),
    (in_equations("α = a;"), "P008", 3, 3),
    ("model M\x00", "P008", 1, 8),
    # strings and comments
    ('model M "abc\n  Real x;\nend M;', "P009", 1, 9),
    ('model M\n  Real x "abc;\n  Real y "def";\nend M;', "P009", 2, 10),
    (in_equations("x = 'a + 1;"), "P009", 3, 7),
    ("model M\n  Real x; /* foo\nend M;", "P010", 2, 11),
    (in_equations("x = 1 /* foo"), "P010", 3, 9),
    # reserved words
    (in_elements("Real end;"), "P011", 2, 8),
    (in_elements("Real input = 3;"), "P011", 2, 8),
    ("model block\nend block;", "P011", 1, 7),
    (in_equations("x = type + 1;"), "P011", 3, 7),
    (in_equations("model = 1;"), "P011", 3, 3),
    # connect
    (in_equations("connect(a.p);"), "P012", 3, 3),
    (in_equations("connect();"), "P012", 3, 3),
    # equations before 'equation'
    (in_elements("v = R*i;"), "P013", 2, 3),
    (in_elements("connect(p, n);"), "P013", 2, 3),
    (in_elements("p.i + n.i = 0;"), "P013", 2, 3),
    (in_elements("der(x) = 0;"), "P013", 2, 3),
    (in_elements("x[1] = 0;"), "P013", 2, 3),
    (in_elements("assert(x > 0, text);"), "P013", 2, 3),
    ("function f\n  input Real x;\n  y := 0;\nend f;", "P013", 3, 3),
    # comparison
    (in_equations("x + y == 3;"), "P014", 3, 8),
    (in_equations("der(x) == 3;"), "P014", 3, 9),
    (in_elements("Real x == 3;"), "P014", 2, 10),
    (in_equations("if x = 3 then y = 1; end if;"), "P014", 3, 8),
    # units
    (in_elements("Resistor r(R = 10[kOhm);"), "P015", 2, 20),
    (in_elements("parameter Real r = 10[kOhm;"), "P015", 2, 24),
    (in_elements("parameter Real r = 10 mm;"), "P015", 2, 25),
    (in_elements("parameter Real r = 10[];"), "P015", 2, 22),
    # outside of classes
    ("model M\nend M;\nx = 3;", "P016", 3, 1),
    ("Resistor r;", "P016", 1, 1),
    ("modle M\nend M;", "P016", 1, 1),
    ("model M\nend M;\nimport a.b;", "P027", 3, 1),
    ("model M\nend M;\nwithin a;", "P027", 3, 1),
    ("", "F106", 1, 1),
    ("  // only a comment\n", "F106", 1, 1),
    # operators
    (in_equations("x = a * -b;"), "P018", 3, 11),
    (in_equations("x = a**2;"), "P018", 3, 8),
    (in_equations("x = a => b;"), "P018", 3, 9),
    (in_equations("x = a < b < c;"), "P018", 3, 13),
    (in_equations("x = a^b^c;"), "P018", 3, 10),
    (in_equations("x + 1;"), "P019", 3, 3),
    # prefixes and declarations
    (in_elements("partial Real x;"), "P020", 2, 3),
    (in_elements("parameter constant Real x;"), "P020", 2, 13),
    (in_elements("Resistor r(Real R = 3);"), "P020", 2, 14),
    (in_equations("x = 1;\n  Real y;"), "P021", 4, 3),
    (in_equations("parameter Real y = 3;"), "P021", 3, 3),
    (in_equations("x = .5;"), "P022", 3, 7),
    (in_elements('Real x "a\\q";'), "P023", 2, 12),
    (in_equations("x = end + 1;"), "P024", 3, 7),
    (in_elements("type E = enumeration(:);"), "P025", 2, 24),
    # small things
    ("Model M\nend M;", "P001", 1, 1),
    ("model M\n  Real x;\nEquation\n  x = 1;\nend M;", "P001", 3, 1),
    ("model M\n  Real x;\nequations\n  x = 1;\nend M;", "P001", 3, 1),
    ("model M\n  Real x;\nEnd M;", "P001", 3, 1),
    ("connector P\n  cross Real v;\nend P;", "P001", 2, 3),
    (in_equations("x = f(a,);"), "P001", 3, 10),
    (in_equations("x = 1;;"), "P001", 3, 9),
    ("model M;\nend M;", "P001", 1, 8),
    ("model M\nequation;\nend M;", "P001", 2, 9),
    (in_equations("x = y = 3;"), "P001", 3, 9),
    (in_elements("Resistor(R = 3);"), "P001", 2, 11),
    (in_elements("Resistor r(R 3);"), "P001", 2, 14),
]


@pytest.mark.parametrize(("text", "code", "line", "column"), CASES)
def test_place_and_code(text: str, code: str, line: int, column: int) -> None:
    found = refused(text)
    assert found.span is not None
    assert (found.code, found.span.line, found.span.column) == (code, line, column), found.message
    assert found.code in CODES
    assert found.help
    assert not found.message.endswith(".")
    assert len(found.message) < 200


@pytest.mark.parametrize("code", sorted({c for _, c, _, _ in CASES}))
def test_line_ends_do_not_move_places(code: str) -> None:
    text, _, line, column = next(case for case in CASES if case[1] == code)
    found = refused("\ufeff" + text.replace("\n", "\r\n"))
    assert found.span is not None
    assert (found.code, found.span.line, found.span.column) == (code, line, column)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (in_equations("x = a − b;"), "write '-'"),
        (in_equations("x = a != b;"), "'<>'"),
        (in_elements("parameter Real r = 10 mm;"), "10[mm]"),
        ("modle M\nend M;", "'model'"),
        (in_elements("v = R*i;"), "'equation'"),
        (in_equations("x = a**2;"), "x^2"),
        (
            "model M\nequation\n  if a then x = 1;\n  else if b then x = 2;\n  end if;\nend M;",
            "elseif",
        ),
        ("model M\nend N;", "end M;"),
        ("model M\nequation\n  x = 1;\n\nmodel N\nend N;", "before line 5"),
    ],
)
def test_help_says_what_to_write(text: str, words: str) -> None:
    assert words in refused(text).help


def test_wrong_end_name_shows_both_places() -> None:
    found = refused("model Pendulum\n  Real x;\nend Pendelum;")
    assert [label.span.line for label in found.labels] == [1]


@pytest.mark.parametrize(
    "text",
    [
        "model M equation x = " + "(" * 100_000,
        "model M equation x = " + "{" * 100_000 + "}" * 100_000 + "; end M;",
        "model M equation x = " + "if a then 1 else " * 5000 + "1; end M;",
        "model M equation " + "for i loop " * 2000 + "end for; " * 2000 + "end M;",
        "".join(f"model M{i} " for i in range(2000))
        + "".join(f"end M{i}; " for i in reversed(range(2000))),
        "model M Real x(" + "a(" * 2000 + ")" * 2001 + "; end M;",
    ],
)
def test_deep_nesting_is_a_message(text: str) -> None:
    assert refused(text).code == "P026"


def test_nesting_of_a_hundred_is_fine() -> None:
    parse_text("model M equation x = " + "(" * 100 + "1" + ")" * 100 + "; end M;", "x")
    parse_text("model M equation x = " + "if a then 1 else " * 100 + "1; end M;", "x")


@pytest.mark.parametrize("word", ["x" * 1_000_000, '"' + "y" * 1_000_000 + '" b', "1" * 300 + "0"])
def test_messages_are_bounded(word: str) -> None:
    found = refused(in_equations(f"z = a {word};"))
    assert len(found.message) + len(found.help) + len(found.label) < 500


def test_first_error_only() -> None:
    found = refused("model A\n  Real x\nend A;\nmodel B\nequation\n  x := 1;\nend B;")
    assert (found.code, found.span and found.span.line) == ("P002", 2)
