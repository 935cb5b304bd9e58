"""Reading source files: encodings, and everything that is no readable file."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from acausal.diagnostics import AcausalError, Diagnostic
from acausal.syntax.parser import parse_file
from acausal.syntax.source_text import MAXIMAL_BYTES

MODEL = 'model A "größe"\n  Real x = 1;\nend A;\n'


def refused(path: Path) -> Diagnostic:
    with pytest.raises(AcausalError) as caught:
        parse_file(path)
    found = caught.value.diagnostics[0]
    assert found.help
    return found


@pytest.mark.parametrize(
    "data",
    [
        MODEL.encode(),
        b"\xef\xbb\xbf" + MODEL.encode(),
        MODEL.replace("\n", "\r\n").encode(),
        MODEL.replace("\n", "\r").encode(),
        MODEL.rstrip().encode(),
    ],
)
def test_encodings_that_are_read(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "a.acm"
    path.write_bytes(data)
    model = parse_file(path).classes[0]
    assert (model.description, model.components[0].span.line) == ("größe", 2)
    assert model.span.source == str(path)


def test_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "latin.acm"
    path.write_bytes('model A\n  Real x "größe";\nend A;'.encode("latin-1"))
    found = refused(path)
    assert found.code == "P030"
    assert found.span is not None
    assert (found.span.line, found.span.column) == (2, 13)
    assert "position 20" in found.message


def test_utf16(tmp_path: Path) -> None:
    path = tmp_path / "wide.acm"
    path.write_text(MODEL, encoding="utf-16")
    found = refused(path)
    assert found.code == "P035"
    assert "UTF-16" in found.message


def test_binary(tmp_path: Path) -> None:
    path = tmp_path / "a.acm"
    path.write_bytes(bytes(range(256)) * 10)
    assert refused(path).code == "P035"


def test_not_there(tmp_path: Path) -> None:
    (tmp_path / "circuit.acm").write_text(MODEL)
    found = refused(tmp_path / "ciruit.acm")
    assert found.code == "F101"
    assert "circuit.acm" in found.help


def test_suffix_left_out(tmp_path: Path) -> None:
    (tmp_path / "circuit.acm").write_text(MODEL)
    assert "circuit.acm" in refused(tmp_path / "circuit").help


def test_directory_not_there(tmp_path: Path) -> None:
    assert "does not exist" in refused(tmp_path / "nowhere" / "a.acm").help


def test_directory(tmp_path: Path) -> None:
    assert refused(tmp_path).code == "F102"


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser reads everything"
)
def test_not_readable(tmp_path: Path) -> None:
    path = tmp_path / "a.acm"
    path.write_text(MODEL)
    path.chmod(0)
    assert refused(path).code == "F103"


def test_name_with_a_zero_byte() -> None:
    assert refused(Path("a\0b.acm")).code == "F103"


def test_too_large(tmp_path: Path) -> None:
    path = tmp_path / "a.acm"
    with path.open("wb") as stream:
        stream.truncate(MAXIMAL_BYTES + 1)
    assert refused(path).code == "F104"
