"""Path patterns: ``*`` stands for any text, ``[*]`` for any subscripts; all else is literal."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache


def is_pattern(text: str) -> bool:
    """Return whether a text is a pattern rather than a path."""
    return "*" in text


@lru_cache(maxsize=256)
def compile_pattern(pattern: str) -> re.Pattern[str]:
    """Return the regular expression of a pattern, for ``fullmatch``."""
    parts = [
        r"\[[^\]]*\]" if piece == "[*]" else ".*" if piece == "*" else re.escape(piece)
        for piece in re.split(r"(\[\*\]|\*+)", re.sub(r"\*+", "*", pattern))
    ]
    return re.compile("".join(parts))


def matching(pattern: str, paths: Iterable[str]) -> list[str]:
    """Return the paths that match, in their order. A pattern without ``*`` is a path."""
    if not is_pattern(pattern):
        return [path for path in paths if path == pattern][:1]
    match = compile_pattern(pattern).fullmatch
    return [path for path in paths if match(path)]
