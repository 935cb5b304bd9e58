"""Rendering of diagnostics: the text a person sees."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from acausal.diagnostics import AcausalError, Diagnostic, Label, Severity, Span
from acausal.diagnostics.excerpt import columns, printable
from acausal.diagnostics.render import as_data, render

SUPPLY = """import electrical.*;

model Supply
  ConstantVoltage a(V = 5[V]);
  ConstantVoltage b(V = 12[V]);
  Ground ground;
equation
  connect(a.p, b.p);
  connect(a.n, b.n);
end Supply;
"""


def span(line, column, end_column, end_line=None, source="<supply>"):
    return Span(source, line, column, end_line or line, end_column)


def shown(diagnostic, text=SUPPLY):
    return render(diagnostic, sources={"<supply>": text})


def test_the_form_of_a_message():
    diagnostic = Diagnostic(
        "S103",
        "two ideal voltage sources fix the same voltage",
        span(4, 19, 20),
        label="fixes a.v",
        labels=(
            Label(span(5, 19, 20), "fixes b.v"),
            Label(span(8, 3, 21), ""),
            Label(span(9, 3, 21), "forces a.v = b.v"),
        ),
        notes=("19 equations, 19 unknowns; the currents a.i and b.i cannot be found",),
        help="put a Resistor in series with one source, or remove one",
    )
    assert shown(diagnostic) == (
        "error[S103]: two ideal voltage sources fix the same voltage\n"
        "  --> <supply>:4:19\n"
        " 4 |   ConstantVoltage a(V = 5[V]);\n"
        "   |                   ^ fixes a.v\n"
        " 5 |   ConstantVoltage b(V = 12[V]);\n"
        "   |                   - fixes b.v\n"
        "...\n"
        " 8 |   connect(a.p, b.p);\n"
        "   |   ------------------\n"
        " 9 |   connect(a.n, b.n);\n"
        "   |   ------------------ forces a.v = b.v\n"
        "note: 19 equations, 19 unknowns; the currents a.i and b.i cannot be found\n"
        "help: put a Resistor in series with one source, or remove one\n"
    )


def test_a_span_over_lines_is_marked_on_each():
    text = "connect(\n    a.p,\n\n    b.p);\n"
    out = shown(Diagnostic("C101", "m", span(1, 1, 9, end_line=4), label="here"), text)
    assert out.splitlines()[2:] == [
        " 1 | connect(",
        "   | ^^^^^^^^",
        " 2 |     a.p,",
        "   |     ^^^^",
        "...",
        " 4 |     b.p);",
        "   |     ^^^^ here",
    ]


def test_a_long_span_shows_its_ends():
    text = "\n".join(f"line {i};" for i in range(1, 101))
    out = shown(Diagnostic("P101", "m", span(2, 1, 8, end_line=99)), text).splitlines()
    numbers = [line.split("|")[0].strip() for line in out if "| line" in line]
    assert numbers == ["2", "3", "4", "99"]


def test_tabs_and_wide_letters_stay_aligned():
    text = "\tx = 漢字 + é;"
    out = shown(Diagnostic("P101", "m", span(1, 11, 12)), text).splitlines()
    source, marks = out[2], out[3]
    assert source[5:] == "    x = 漢字 + é;"
    assert columns(source[5 : source.index("é")]) == marks.index("^") - 5


def test_only_a_part_of_a_very_long_line_is_shown():
    text = "a" * 5_000_000 + "!" + "b" * 5_000_000
    out = shown(Diagnostic("P101", "m", span(1, 5_000_001, 5_000_002), label="odd"), text)
    source, marks = out.splitlines()[2:4]
    assert len(source) < 130
    assert source[marks.index("^")] == "!"


def test_places_outside_the_text_are_moved_into_it():
    for place in (span(99, 99, 120), span(1, 500, 501), span(4, 3, 4, end_line=400)):
        out = shown(Diagnostic("P101", "m", place, label="here"))
        assert "^ here" in out


def test_a_source_that_is_gone_is_still_named():
    gone = Span("no/such/file.acm", 3, 7, 3, 9)
    out = render(Diagnostic("P101", "m", gone, "primary", (Label(gone, "second"),)))
    assert out == (
        "error[P101]: m\n  --> no/such/file.acm:3:7\n  = line 3: primary\n  = line 3: second\n"
    )


def test_files_are_read_whatever_their_bytes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.acm").write_bytes(b"\xef\xbb\xbfmodel \xff\x1b[31m\r\nend;\r\n")
    place = Span(str(tmp_path / "a.acm"), 1, 7, 1, 8)
    out = render(Diagnostic("P101", "m", place))
    assert "--> a.acm:1:7" in out
    assert "\x1b" not in out
    assert "\r" not in out


def test_other_files_get_their_own_excerpt(tmp_path):
    (tmp_path / "b.acm").write_text("connector Pin\n", encoding="utf-8")
    other = Label(Span(str(tmp_path / "b.acm"), 1, 11, 1, 14), "declared here")
    out = shown(Diagnostic("C102", "m", span(8, 3, 20), labels=(other,)))
    assert out.count("-->") == 2
    assert "connector Pin" in out
    assert "--- declared here" in out


def test_warning_color_and_limits():
    warning = Diagnostic("U101", "m", severity=Severity.WARNING)
    assert render(warning) == "warning[U101]: m\n"
    assert "\x1b[1;33mwarning[U101]\x1b[0m" in render(warning, color=True)
    many = render(AcausalError([Diagnostic("P101", f"m{i}") for i in range(30)]))
    assert "m19" in many
    assert "m20" not in many
    assert "10 more messages" in many
    long = render(Diagnostic("P101", "x" * 100_000, notes=["n"] * 100))
    assert len(long) < 3000
    assert render([]) == ""


def test_data_is_json():
    data = as_data(Diagnostic("P101", "m", span(1, 2, 3), labels=(Label(span(2, 3, 4), "l"),)))
    assert json.loads(json.dumps(data)) == data
    assert data["span"]["column"] == 2
    assert data["labels"][0]["text"] == "l"


@given(
    st.text(max_size=200),
    st.tuples(*[st.integers(0, 12)] * 4),
    st.booleans(),
)
def test_any_text_and_any_place_render(text, place, color):
    line, column, end_line, end_column = place
    diagnostic = Diagnostic("P101", text, Span("<supply>", line, column, end_line, end_column))
    out = render(diagnostic, color=color, sources={"<supply>": text})
    if not color:
        assert all(c == "\n" or printable(c) == c for c in out)
    assert out.endswith("\n")


@pytest.mark.parametrize(("text", "width"), [("abc", 3), ("\t", 4), ("漢", 2), ("e\u0301", 1)])
def test_columns(text, width):
    assert columns(text) == width
