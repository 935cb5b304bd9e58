"""Rules for syntax errors that a look at neighbouring tokens explains.

Each rule looks at the surroundings of an error and raises its diagnostic if it knows the cause.
"""

from __future__ import annotations

from typing import NoReturn

from acausal.diagnostics import Label, fail
from acausal.syntax.error_context import KEYWORDS, OPERATORS, PREFIX_WORDS, SIGNS, Context, Lexeme
from acausal.syntax.error_text import explain_character, report_semicolon, shorten

SECTION_STARTS = frozenset(("equation", "algorithm", "public", "protected", "initial", "end"))


def unterminated(c: Context) -> None:
    """Find strings, comments and quoted names that are not closed."""
    for lexeme in (*c.before[-1:], *c.after[:1]):
        if lexeme.sort == "comment":
            fail(
                "P010",
                "this comment is never closed",
                c.span(lexeme),
                help="close it with '*/'",
            )
        if lexeme.sort == "quote":
            fail("P009", "this string is never closed", c.span(lexeme), help="close it with '\"'")
        if lexeme.sort == "tick":
            fail(
                "P009",
                "this quoted name is not closed on its line",
                c.span(lexeme),
                help="close it with \"'\"; a string is written with '\"'",
            )
    previous = c.previous
    if (
        previous is not None
        and previous.sort == "string"
        and not c.single
        and "\n" in previous.text
    ):
        line_end = previous.start + previous.text.index("\n")
        opening = Lexeme("string", "", previous.start, line_end)
        fail(
            "P009",
            "this string is not closed where it should be",
            c.span(opening),
            labels=[
                Label(c.behind(previous), "it ends only here, and this does not fit behind it")
            ],
            help="close it with '\"'",
        )
    # An unclosed comment swallows nothing: the parser saw the '/' alone.
    if len(c.before) >= 1 and c.before[-1].text == "/" and c.token and c.token.text == "*":
        fail("P010", "this comment is never closed", c.span(c.before[-1], c.token))


def unknown_character(c: Context) -> None:
    """Find characters that are no part of the language."""
    if c.token is not None and c.token.sort == "unknown":
        explain_character(c, c.token)


def nothing_there(c: Context) -> None:
    """Find the empty expression."""
    if c.single and not c.before and c.token is None:
        fail(
            "P017", "the expression is empty", c.behind(None), help="write a value, such as 10[mm]"
        )


def unit(c: Context) -> None:
    """Find what is wrong behind a number: a unit without brackets, or not closed."""
    token, previous = c.token, c.previous
    if token is None or previous is None or previous.sort not in ("number", "quantity"):
        return
    if token.text == "[":
        line_end = c.text.find("\n", token.start)
        line = c.text[token.start : line_end if line_end >= 0 else len(c.text)]
        if "]" not in line:
            fail(
                "P015",
                "the unit behind this number has no closing ']'",
                c.span(token),
                help="write the unit in brackets: 10[kOhm]",
            )
        fail(
            "P015",
            "the brackets behind a number hold its unit, and this is none",
            c.span(token),
            help="write a unit, such as 10[kOhm] or 25[N/mm]",
        )
    closes_condition = {"THEN", "LOOP"} & c.accepts and c.following not in ("then", "loop")
    if token.is_name and not c.on_new_line and not closes_condition:
        fail(
            "P015",
            f"'{shorten(token.text)}' cannot follow a number",
            c.span(token),
            help=f"if it is a unit, write {previous.text}[{shorten(token.text)}]; for a product"
            f" write {previous.text}*{shorten(token.text)}",
        )


def number_form(c: Context) -> None:
    """Find a number that begins with its point."""
    token, previous = c.token, c.previous
    if token is not None and token.sort == "number" and previous and previous.text == ".":
        fail(
            "P022",
            "a number does not begin with a point",
            c.span(previous, token),
            help=f"write 0.{token.text}",
        )


def superfluous(c: Context) -> None:
    """Find a semicolon or comma too many."""
    token, previous = c.token, c.previous
    if token is None or previous is None:
        return
    if token.text == ";" and (previous.text == ";" or not c.item) and not c.brackets:
        if previous.text == ";":
            fail(
                "P001",
                "there is nothing before this ';'",
                c.span(token),
                help="remove the second ';'",
            )
        if previous.is_keyword or (c.enclosing_class and previous.text == c.enclosing_class.name):
            fail(
                "P001", f"no ';' belongs behind '{previous.text}'", c.span(token), help="remove it"
            )
    if previous.text == "," and token.text in (")", "}", "]", ";"):
        fail(
            "P001",
            f"something is missing between ',' and '{token.text}'",
            c.span(previous),
            help="remove the comma, or write what follows it",
        )


def assignment_sign(c: Context) -> None:
    """Find '=', ':=' and '==' in each other's place."""
    token = c.token
    if token is None:
        return
    block = c.enclosing_class
    if token.text == ":=" and block is not None and block.section == "equation":
        fail(
            "P006",
            "':=' assigns in an algorithm; an equation is written with '='",
            c.span(token),
            help="write '=', or move the line into a section 'algorithm'",
        )
    if token.text in ("=", "==") and "ASSIGN" in c.accepts and "EQ" not in c.accepts:
        fail(
            "P006",
            f"an algorithm assigns with ':=', not with '{token.text}'",
            c.span(token),
            help="write ':=', or move the line into a section 'equation'",
        )
    named = c.previous is not None and (c.previous.is_name or c.previous.text in (")", "]"))
    if token.text == "==" and named:
        fail(
            "P014",
            "'==' compares two values; a value is given with '='",
            c.span(token),
            help="write a single '='",
        )
    if token.text == "=" and "IN" in c.accepts:
        fail(
            "P005",
            "a loop index takes its values with 'in', not with '='",
            c.span(token),
            help="write 'for i in 1:n loop'",
        )
    if token.text == "=" and "THEN" in c.accepts:
        fail(
            "P014",
            "a condition compares with '=='; '=' states an equation",
            c.span(token),
            help="write '=='",
        )


def second_equal_sign(c: Context) -> None:
    """A line without semicolon that goes on as a call or a sum is seen at the next ``=``."""
    token = c.token
    if token is None or token.text not in ("=", ":=") or c.brackets:
        return
    sign = next((t for t in c.item if t.text in ("=", ":=")), None)
    if sign is None:
        return
    line_start = c.text.rfind("\n", 0, token.start)
    earlier = [t for t in c.item if t.end <= line_start]
    if sign in earlier:
        report_semicolon(c, earlier[-1])
    fail(
        "P001",
        f"an equation has one '{token.text}', and this is the second",
        c.span(token),
        labels=[Label(c.span(sign), "the first")],
        help="write two equations; a comparison is written '=='",
    )


def sign_order(c: Context) -> None:
    """Find operators that are none, and signs behind operators."""
    token, previous = c.token, c.previous
    if token is None or previous is None:
        return
    for first, second in [*zip(c.after, c.after[1:2], strict=False), (previous, token)]:
        if first.text == "=" and second.text in ("<", ">") and first.end == second.start:
            fail(
                "P018",
                f"'={second.text}' is no operator",
                c.span(first, second),
                help=f"write '{second.text}='",
            )
    if token.text in ("*", ".*") and previous.text == "*":
        fail("P018", "'**' is no operator", c.span(previous, token), help="a power is written x^2")
    if previous.text not in OPERATORS:
        return
    if token.text in SIGNS and previous.text in ("+", "-") and previous.end == token.start:
        fail(
            "P018",
            f"'{previous.text}{token.text}' is no operator",
            c.span(previous, token),
            help="write x = x + 1 in full, and a second sign in parentheses: a - (-b)",
        )
    if token.text in SIGNS:
        fail(
            "P018",
            f"a sign cannot follow '{previous.text}' directly",
            c.span(token),
            help=f"put it in parentheses: a{previous.text}({token.text}b)",
        )
    if token.text == "not":
        fail(
            "P018",
            f"'not' cannot follow '{previous.text}' directly",
            c.span(token),
            help="put it in parentheses: (not b)",
        )


def brackets(c: Context) -> None:
    """Find brackets that do not match."""
    token = c.token
    if token is None or token.text == ";" or token.text in SECTION_STARTS:
        # At an if-expression without else, that is the nearer mistake.
        if c.brackets and not ("ELSE" in c.accepts and "RPAR" not in c.accepts):
            bracket = c.brackets[-1]
            if token is not None and token.text == ";" and c.previous and c.previous.text == ",":
                return
            fail(
                "P007",
                f"this '{bracket.text}' is never closed",
                c.span(bracket),
                labels=[Label(c.span(token), "reached without the closing bracket")]
                if token is not None
                else [],
                help=f"add '{_partner(bracket)}'",
            )
        return
    if token.text in (")", "]", "}"):
        if not c.brackets:
            fail(
                "P007",
                f"this '{token.text}' closes nothing",
                c.span(token),
                help=f"remove it, or open with '{_partner(token)}' before",
            )
        bracket = c.brackets[-1]
        if _partner(bracket) != token.text:
            fail(
                "P007",
                f"'{bracket.text}' is closed by '{token.text}'",
                c.span(token),
                labels=[Label(c.span(bracket), f"opened here, closes with '{_partner(bracket)}'")],
                help=f"write '{_partner(bracket)}', or add the missing bracket before",
            )


def _partner(bracket: Lexeme) -> str:
    return {"(": ")", "[": "]", "{": "}", ")": "(", "]": "[", "}": "{"}[bracket.text]


def wrong_case(c: Context) -> None:
    """``Equation`` or ``End`` is a name to the parser, which fails at what follows it."""
    for lexeme in (c.token, c.previous):
        if lexeme is None or lexeme.sort != "word" or lexeme.text in KEYWORDS:
            continue
        if lexeme.text.lower() in KEYWORDS:
            report_case(c, lexeme)


def names_in_a_row(c: Context) -> None:
    """``cross Real v;`` or ``R 3``: something is missing or misspelt between two operands."""
    token, previous = c.token, c.previous
    if token is None or previous is None or c.on_new_line or not previous.is_name:
        return
    if token.sort in ("number", "quantity", "string") and (c.brackets or token.sort != "string"):
        name, value = shorten(previous.text), shorten(token.text)
        fail(
            "P001",
            f"something is missing between '{name}' and '{value}'",
            c.span(previous, token),
            help=f"write '{name} = {value}' to give a value, '{name}*{value}' for a product",
        )
    if not token.is_name or len(c.item) < 2 or c.brackets:
        return
    if not all(t.is_name or t.text == "." for t in c.item) or c.item[-2].text == ".":
        return
    from difflib import get_close_matches

    first = c.item[0]
    close = get_close_matches(first.text.lower(), sorted(PREFIX_WORDS), n=1)
    if close:
        fail(
            "P001",
            f"'{shorten(first.text)}' is not a word of the language",
            c.span(first),
            help=f"did you mean '{close[0]}'?",
        )
    names = " ".join(shorten(t.text) for t in (*c.item, token))
    fail(
        "P001",
        f"'{names}' is no declaration: it has a name too many",
        c.span(first, token),
        help="a declaration is a type and a name, such as 'Real x;'",
    )


def reserved_word(c: Context) -> None:
    """Find a reserved word where a name belongs."""
    token = c.token
    if token is None or not token.is_keyword or "IDENT" not in c.accepts:
        return
    if c.following not in (";", "=", ":=", ",", "(", "[", ")", "]", ".", "}") and c.on_new_line:
        return
    if c.on_new_line and token.text in ("then", "loop", "else", "elseif", "end", "in"):
        return
    fail(
        "P011",
        f"'{token.text}' is a reserved word and cannot be a name",
        c.span(token),
        help=f"choose another name, or quote it: '{token.text}_' or \"'{token.text}'\"",
    )


def report_case(c: Context, lexeme: Lexeme) -> NoReturn:
    """Raise P001 for a keyword written with capital letters."""
    fail(
        "P001",
        f"'{lexeme.text}' is not a word of the language",
        c.span(lexeme),
        help=f"capital and small letters differ: write '{lexeme.text.lower()}'",
    )
