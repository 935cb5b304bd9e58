"""Expressions: precedence, round trips through text, spans, literals."""

from __future__ import annotations

import string
from dataclasses import fields, is_dataclass
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from acausal.diagnostics import AcausalError, Span
from acausal.syntax import tree
from acausal.syntax.error_context import KEYWORDS
from acausal.syntax.formatter import format_expression
from acausal.syntax.parser import parse_expression

NOWHERE = Span("<test>", 1, 1, 1, 1)


def without_spans(node: Any) -> Any:
    """Return a tree as nested tuples of class names and values, places left out."""
    if is_dataclass(node):
        values = [without_spans(getattr(node, f.name)) for f in fields(node) if f.name != "span"]
        return (type(node).__name__, *values)
    if isinstance(node, tuple):
        return tuple(without_spans(item) for item in node)
    return node


def bracketed(node: tree.Expression) -> str:
    """Return an expression with every operator application in parentheses."""
    match node:
        case tree.Binary(_, operator, left, right):
            return f"({bracketed(left)} {operator} {bracketed(right)})"
        case tree.Unary(_, operator, operand):
            return f"({operator} {bracketed(operand)})"
        case tree.RangeExpression(_, start, step, stop):
            parts = [start, stop] if step is None else [start, step, stop]
            return "(" + " : ".join(bracketed(p) for p in parts) + ")"
        case tree.IfExpression(_, branches, otherwise):
            inner = " ".join(f"{bracketed(c)} ? {bracketed(v)}" for c, v in branches)
            return f"({inner} | {bracketed(otherwise)})"
        case _:
            return format_expression(node)


@pytest.mark.parametrize(
    ("text", "grouped"),
    [
        ("a + b*c", "(a + (b * c))"),
        ("a - b - c", "((a - b) - c)"),
        ("a/b/c", "((a / b) / c)"),
        ("a/b*c", "((a / b) * c)"),
        ("-a^2", "(- (a ^ 2))"),
        ("-a*b", "(- (a * b))"),
        ("-a + b", "((- a) + b)"),
        ("a^b*c", "((a ^ b) * c)"),
        ("(a^b)^c", "((a ^ b) ^ c)"),
        ("a < -b", "(a < (- b))"),
        ("a + b < c*d", "((a + b) < (c * d))"),
        ("not a < b", "(not (a < b))"),
        ("not a and b", "((not a) and b)"),
        ("a or b and c", "(a or (b and c))"),
        ("a and b or c and d", "((a and b) or (c and d))"),
        ("a or not b or c", "((a or (not b)) or c)"),
        ("a == b or c <> d", "((a == b) or (c <> d))"),
        ("1:n + 1", "(1 : (n + 1))"),
        ("1:2:n", "(1 : 2 : n)"),
        ("a .* b .+ c ./ d .^ e", "((a .* b) .+ (c ./ (d .^ e)))"),
        ("if a then b else c + d", "(a ? b | (c + d))"),
        ("if a then b elseif c then d else e", "(a ? b c ? d | e)"),
        ("if a then b else if c then d else e", "(a ? b | (c ? d | e))"),
        ("2.*x", "(2.0 * x)"),
    ],
)
def test_precedence(text: str, grouped: str) -> None:
    assert bracketed(parse_expression(text)) == grouped


@pytest.mark.parametrize(
    "text",
    [
        "a - (b - c)",
        "a/(b*c)",
        "(-a)^2",
        "(-a)*b",
        "a*(-b)",
        "a - (-b)",
        "(a + b)*c",
        "-(a + b)",
        "(not a) == b",
        "(a < b) == (c < d)",
        "sum(a:b)",
        "(if a then b else c) + 1",
        "{i^2 for i in 1:n, j}",
        "[1, 2; 3, 4]",
        "x[end, :].y[2:end - 1]",
        ".a.b",
        "f(x, n = 3)",
        "der(x)",
        "initial()",
        "sum(i*x[i] for i in 1:n)",
        "10[kOhm]*R",
        '"say \\"hi\\"\\n"',
        "'a name'.b",
        "x[if a then end else 1]",
        "1e+22",
    ],
)
def test_minimal_parentheses_are_kept(text: str) -> None:
    assert format_expression(parse_expression(text)) == text


@pytest.mark.parametrize(
    ("text", "tidy"),
    [("((a))*((b+c))", "a*(b + c)"), ("(a*b)+c", "a*b + c"), ("a+(b*c)", "a + b*c")],
)
def test_needless_parentheses_are_left_out(text: str, tidy: str) -> None:
    assert format_expression(parse_expression(text)) == tidy


@pytest.mark.parametrize(
    ("text", "value", "integer", "unit"),
    [
        ("10", 10.0, True, None),
        ("1.", 1.0, False, None),
        ("1.5e-3", 1.5e-3, False, None),
        ("2E3", 2000.0, False, None),
        ("10[kOhm]", 10.0, True, "kOhm"),
        ("10 [kOhm]", 10.0, True, "kOhm"),
        ("2.5[N.m/rad]", 2.5, False, "N.m/rad"),
        ("1300[1/min]", 1300.0, True, "1/min"),
        ("9.81[m/s2]", 9.81, False, "m/s2"),
        ("3[W/(m2.K)]", 3.0, True, "W/(m2.K)"),
        ("20[degC]", 20.0, True, "degC"),
        ("5[%]", 5.0, True, "%"),
        ("4[ kg.m2 ]", 4.0, True, "kg.m2"),
        ("7[µm]", 7.0, True, "µm"),
    ],
)
def test_numbers(text: str, value: float, integer: bool, unit: str | None) -> None:
    number = parse_expression(text)
    assert isinstance(number, tree.NumberLiteral)
    assert (number.value, number.integer, number.unit) == (value, integer, unit)


def test_subscript_of_a_name_is_no_unit() -> None:
    reference = parse_expression("x[m]")
    assert isinstance(reference, tree.Reference)
    assert format_expression(reference.parts[0].subscripts[0]) == "m"


def test_string_escapes() -> None:
    literal = parse_expression(r'"a\"b\\c\n\t\?\'"')
    assert isinstance(literal, tree.StringLiteral)
    assert literal.value == "a\"b\\c\n\t?'"


def test_spans_cover_operands_and_parentheses() -> None:
    text = "  (a + b)*f(c,\n    d)"
    product = parse_expression(text, "x")
    assert isinstance(product, tree.Binary)
    assert product.span == Span("x", 1, 3, 2, 7)
    assert product.left.span == Span("x", 1, 3, 1, 10)
    assert product.right.span == Span("x", 1, 11, 2, 7)
    assert isinstance(product.left, tree.Binary)
    assert product.left.right.span == Span("x", 1, 8, 1, 9)


def test_spans_of_a_reference() -> None:
    reference = parse_expression("a.bc[12].d")
    assert isinstance(reference, tree.Reference)
    assert [(p.span.column, p.span.end_column) for p in reference.parts] == [
        (1, 2),
        (3, 9),
        (10, 11),
    ]
    assert reference.span.end_column == 11


def test_comments_are_blanks() -> None:
    assert format_expression(parse_expression("a /* one * / ** */ + // two\n b")) == "a + b"


@pytest.mark.parametrize(
    ("text", "code", "column"),
    [
        ("", "P017", 1),
        ("a +", "P001", 4),
        ("a b", "P001", 3),
        ("a < b < c", "P018", 7),
        ("a^b^c", "P018", 4),
        ("a*-b", "P018", 3),
        ("a = b", "P001", 3),
        ("(a", "P007", 1),
        ("a)", "P007", 2),
        ("1 + end", "P011", 5),
        ("f(end)", "P024", 3),
        ("10 mm", "P015", 4),
        ("10[]", "P015", 1),
        ("1e999", "P022", 1),
        ("a # b", "P008", 3),
        ('"abc', "P009", 1),
        ("a /* b", "P010", 3),
        ("f(a = 1, 2)", "P001", 10),
    ],
)
def test_errors_in_a_lone_expression(text: str, code: str, column: int) -> None:
    with pytest.raises(AcausalError) as caught:
        parse_expression(text)
    diagnostic = caught.value.diagnostics[0]
    assert diagnostic.span is not None
    assert (diagnostic.code, diagnostic.span.column) == (code, column)


def test_a_sum_of_ten_thousand_terms() -> None:
    text = " + ".join(f"x{i}" for i in range(10_000))
    assert format_expression(parse_expression(text)) == text


# --- property: the text of a tree parses to the same tree ------------------------------------

names = st.one_of(
    st.text(string.ascii_letters + "_", min_size=1, max_size=4),
    st.sampled_from(["across", "through", "endless", "iff", "'a b'", "der_x", "in_"]),
).filter(lambda name: name not in KEYWORDS)

numbers = st.one_of(
    st.integers(0, 10**9).map(lambda n: tree.NumberLiteral(NOWHERE, float(n), True)),
    st.floats(0, 1e30, allow_nan=False, allow_subnormal=False).map(
        lambda x: tree.NumberLiteral(NOWHERE, abs(x), False)
    ),
    st.sampled_from(["kOhm", "N.m/rad", "W/(m2.K)", "%", "1/min"]).map(
        lambda unit: tree.NumberLiteral(NOWHERE, 2.5, False, unit)
    ),
)
simple_references = st.tuples(st.lists(names, min_size=1, max_size=3), st.booleans()).map(
    lambda pair: tree.Reference(
        NOWHERE, tuple(tree.NamePart(NOWHERE, name) for name in pair[0]), pair[1]
    )
)
leaves = st.one_of(
    numbers,
    simple_references,
    st.booleans().map(lambda value: tree.BooleanLiteral(NOWHERE, value)),
    st.text(string.printable, max_size=5)
    .filter(lambda text: "\r" not in text)
    .map(lambda text: tree.StringLiteral(NOWHERE, text)),
)
BINARY = [
    "+",
    "-",
    "*",
    "/",
    "^",
    ".+",
    ".-",
    ".*",
    "./",
    ".^",
    "<",
    "<=",
    ">",
    ">=",
    "==",
    "<>",
    "and",
    "or",
]


def larger(inner: st.SearchStrategy[tree.Expression]) -> st.SearchStrategy[tree.Expression]:
    """Return expressions made of others."""
    several = st.lists(inner, min_size=1, max_size=3).map(tuple)
    indices = st.lists(
        st.builds(tree.ForIndex, st.just(NOWHERE), names, st.none() | inner), min_size=1, max_size=2
    ).map(tuple)
    subscripts = st.lists(
        inner | st.just(tree.Colon(NOWHERE)) | st.just(tree.End(NOWHERE)), min_size=1, max_size=2
    ).map(tuple)
    return st.one_of(
        st.builds(tree.Binary, st.just(NOWHERE), st.sampled_from(BINARY), inner, inner),
        st.builds(
            tree.Unary, st.just(NOWHERE), st.sampled_from(["-", "+", "not", ".-", ".+"]), inner
        ),
        st.builds(
            tree.IfExpression,
            st.just(NOWHERE),
            st.lists(st.tuples(inner, inner), min_size=1, max_size=2).map(tuple),
            inner,
        ),
        st.builds(tree.RangeExpression, st.just(NOWHERE), inner, st.none() | inner, inner),
        st.builds(tree.ArrayLiteral, st.just(NOWHERE), several),
        st.builds(tree.ArrayComprehension, st.just(NOWHERE), inner, indices),
        st.builds(
            tree.MatrixLiteral,
            st.just(NOWHERE),
            st.lists(several, min_size=1, max_size=2).map(tuple),
        ),
        st.builds(
            lambda name, items: tree.Reference(
                NOWHERE, (tree.NamePart(NOWHERE, name, items), tree.NamePart(NOWHERE, "y"))
            ),
            names,
            subscripts,
        ),
        st.builds(
            tree.Call,
            st.just(NOWHERE),
            simple_references,
            several,
            st.lists(st.builds(tree.NamedArgument, st.just(NOWHERE), names, inner), max_size=2).map(
                tuple
            ),
        ),
        st.builds(
            lambda f, e, i: tree.Call(NOWHERE, f, (e,), (), i), simple_references, inner, indices
        ),
    )


expressions = st.recursive(leaves, larger, max_leaves=12)


@settings(max_examples=300, deadline=None)
@given(expressions)
def test_text_of_a_tree_parses_to_the_same_tree(expression: tree.Expression) -> None:
    text = format_expression(expression)
    assert without_spans(parse_expression(text)) == without_spans(expression), text
