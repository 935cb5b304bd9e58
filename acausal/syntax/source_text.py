"""Source files to text: reading, decoding, and refusing what no person wrote."""

from __future__ import annotations

import re
from pathlib import Path

from acausal.diagnostics import Span, fail

MAXIMAL_BYTES = 5_000_000
"""Larger files are refused; they are data, not component text."""

MAXIMAL_BRACKETS = 150
"""Brackets inside each other; deeper text is refused."""

_BRACKETS = re.compile(
    r"""[(\[{]|[)\]}]|"[^"\\]*(?:\\.[^"\\]*)*(?:"|\Z)|'(?:[^'\\\n]|\\.)+'|//[^\n]*|/\*.*?(?:\*/|\Z)""",
    re.DOTALL,
)
_CONTROL = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")


def read_source(path: Path) -> str:
    """Return the text of a source file.

    Raises:
        AcausalError: As :func:`read_bytes` and :func:`decode`.
    """
    return decode(read_bytes(path), str(path))


def read_bytes(path: Path) -> bytes:
    """Return the content of a source file.

    Raises:
        AcausalError: F101 not found, F102 a directory, F103 not readable, F104 too large.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(MAXIMAL_BYTES + 1)
    except FileNotFoundError:
        fail("F101", f"there is no file {path}", help=_similar_file(path))
    except IsADirectoryError:
        fail(
            "F102",
            f"{path} is a directory, not a file",
            help="name a file in it; a directory of .acm files is a package and is imported",
        )
    except PermissionError:
        fail("F103", f"{path} cannot be read: permission denied", help=f"try 'chmod u+r {path}'")
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        fail("F103", f"{path} cannot be read: {reason}", help="check the path and the disk")
    if len(data) > MAXIMAL_BYTES:
        fail(
            "F104",
            f"{path} is larger than {MAXIMAL_BYTES // 1_000_000} MB",
            help="divide it into several files, and write repeated parts as arrays of components",
        )
    return data


def decode(data: bytes, source: str) -> str:
    """Return the text of UTF-8 data, without a byte order mark and with plain line ends.

    Raises:
        AcausalError: P030 for other encodings, P035 for binary data.
    """
    zero = data.find(b"\0")
    if zero >= 0:
        wide = data[:2] in (b"\xff\xfe", b"\xfe\xff")
        fail(
            "P035",
            f"{source} is {'UTF-16 text' if wide else 'binary data'}, not UTF-8 text",
            _byte_place(data, zero, source),
            label=f"byte {zero} is zero",
            help="save the file as UTF-8" if wide else "name a text file with models",
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        # The codec counts behind a byte order mark.
        position = error.start + (3 if data.startswith(b"\xef\xbb\xbf") else 0)
        fail(
            "P030",
            f"{source} is not UTF-8 text: byte {data[position]:#04x} at position {position}",
            _byte_place(data, position, source),
            help="save the file as UTF-8 in your editor",
        )
    return text.replace("\r\n", "\n").replace("\r", "\n")


def check_text(text: str, source: str) -> str:
    """Return ``text`` ready for the lexer; refuse control characters and extreme nesting.

    Raises:
        AcausalError: P008 for a control character, P026 for too many nested brackets.
    """
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    control = _CONTROL.search(text)
    if control:
        fail(
            "P008",
            f"the control character U+{ord(control[0]):04X} does not belong into a model",
            place(text, control.start(), control.end(), source),
            help="delete it",
        )
    depth = 0
    for match in _BRACKETS.finditer(text):
        mark = match[0]
        if mark in "([{":
            depth += 1
            if depth > MAXIMAL_BRACKETS:
                fail(
                    "P026",
                    f"more than {MAXIMAL_BRACKETS} brackets inside each other",
                    place(text, match.start(), match.end(), source),
                    help="give inner parts a name: declare a variable for each",
                )
        elif mark in ")]}":
            depth -= depth > 0
    return text


def place(text: str, start: int, end: int, source: str) -> Span:
    """Return the span of the characters ``start`` to ``end`` (exclusive) of ``text``."""
    line = text.count("\n", 0, start) + 1
    column = start - text.rfind("\n", 0, start)
    end_line = line + text.count("\n", start, end)
    end_column = end - text.rfind("\n", 0, end)
    return Span(source, line, column, end_line, end_column)


def _byte_place(data: bytes, position: int, source: str) -> Span:
    before = data[:position]
    line = before.count(b"\n") + 1
    begin = before.rfind(b"\n") + 1
    column = len(before[begin:].decode("utf-8", errors="replace")) + 1
    return Span(source, line, column, line, column + 1)


def _similar_file(path: Path) -> str:
    if not path.parent.is_dir():
        return f"the directory {path.parent} does not exist either"
    from difflib import get_close_matches

    try:
        names = sorted(p.name for p in path.parent.iterdir() if p.is_file())
    except (OSError, ValueError):
        names = []
    close = get_close_matches(path.name, names, n=1)
    if not close and path.suffix == "" and f"{path.name}.acm" in names:
        close = [f"{path.name}.acm"]
    return f"did you mean {path.parent / close[0]}?" if close else "check the path"
