"""Mistakes people make: each gets a message with the right code, the right line and a way out.

The expected code stands in the file: ``// expect: N101`` in the line the message must point at,
``// expect: P009 at line 4`` where that line cannot hold a comment, ``// expect-anywhere: B101``
for messages about a whole model.
"""

from __future__ import annotations

import random
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from acausal import compile_file
from acausal.diagnostics import AcausalError, Diagnostic
from acausal.diagnostics.render import render

HERE = Path(__file__).parent
FILES = sorted(HERE.glob("*.acm"))
EXPECTATION = re.compile(r"//\s*expect(-anywhere)?:\s*([A-Z]\d{3})(?:\s+at line (\d+))?")


@dataclass(frozen=True)
class Expectation:
    """A code, and the line it must point at if that is known."""

    code: str
    line: int | None


def expectation(path: Path) -> Expectation:
    for number, text in enumerate(path.read_text().splitlines(), 1):
        if found := EXPECTATION.search(text):
            anywhere, code, line = found.groups()
            return Expectation(code, None if anywhere else int(line or number))
    raise ValueError(f"{path.name} does not say what it expects")


def diagnostics(path: Path) -> tuple[Diagnostic, ...]:
    """Take a file all the way to a trajectory and return what was said about it."""
    try:
        said: tuple[Diagnostic, ...] = compile_file(path).simulate(stop_time=2.0).diagnostics
    except AcausalError as error:
        return error.diagnostics
    return said


def test_there_are_enough_mistakes() -> None:
    assert len(FILES) >= 40


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_mistake(path: Path) -> None:
    expected = expectation(path)
    found = diagnostics(path)
    assert found, "nothing was said"
    first = found[0]
    text = render(found)
    assert first.code == expected.code, text
    if expected.line is not None:
        assert first.span is not None, text
        assert first.span.line == expected.line, text
    assert first.help, text
    assert first.message and not first.message.endswith("."), text
    assert "Traceback" not in text
    assert path.name in text or first.span is None, text


def refused(path: Path) -> Diagnostic:
    with pytest.raises(AcausalError) as caught:
        compile_file(path)
    first: Diagnostic = caught.value.diagnostics[0]
    assert first.help
    return first


def test_file_not_found(tmp_path: Path) -> None:
    (tmp_path / "circuit.acm").write_text("model A\nend A;\n")
    first = refused(tmp_path / "ciruit.acm")
    assert first.code[0] == "F"
    assert "circuit.acm" in first.help


def test_folder_instead_of_a_file(tmp_path: Path) -> None:
    assert refused(tmp_path).code[0] == "F"


def test_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "latin1.acm"
    path.write_bytes('model A "Gr\xf6\xdfe"\n  Real x = 1;\nend A;\n'.encode("latin-1"))
    first = refused(path)
    assert first.code[0] in "FP"
    assert first.span is not None and first.span.line == 1


def test_empty_file(tmp_path: Path) -> None:
    path = tmp_path / "empty.acm"
    path.write_text("")
    assert refused(path).code[0] in "FN"


def test_unknown_model(tmp_path: Path) -> None:
    path = tmp_path / "two.acm"
    path.write_text(
        "model Pump\n  Real x = 1;\nend Pump;\nmodel Motor\n  Real x = 1;\nend Motor;\n"
    )
    with pytest.raises(AcausalError) as caught:
        compile_file(path, model="Mtor")
    first = caught.value.diagnostics[0]
    assert first.code[0] in "FN"
    assert "Motor" in first.help + first.message


@pytest.mark.parametrize("kind", ["bytes", "letters", "brackets", "words"])
def test_ten_megabytes_of_noise(kind: str, tmp_path: Path) -> None:
    source = random.Random(1)
    size = 10_000_000
    if kind == "bytes":
        data = source.randbytes(size)
    elif kind == "letters":
        data = bytes(source.choices(b"abcdefghij klmnop\n", k=size))
    elif kind == "brackets":
        data = b"model A\nequation\n  x = " + b"(" * size
    else:
        words = [b"model ", b"end ", b"; ", b"if ", b"then ", b"Real x ", b"equation\n", b"= 1 "]
        data = b"".join(source.choices(words, k=size // 5))
    path = tmp_path / "noise.acm"
    path.write_bytes(data)
    first = refused(path)
    assert first.code[0] in "FP"
    assert len(render([first])) < 5000


@pytest.mark.parametrize(
    "name", ["misspelt_class", "two_voltage_sources_in_parallel", "missing_semicolon"]
)
def test_command_line_shows_no_traceback(name: str) -> None:
    path = HERE / f"{name}.acm"
    run = subprocess.run(
        [sys.executable, "-m", "acausal", "check", str(path)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode != 0
    assert f"error[{expectation(path).code}]" in run.stderr
    assert "help:" in run.stderr
    assert "Traceback" not in run.stderr + run.stdout
