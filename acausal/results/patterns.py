"""Path patterns, with the meaning they have in a model.

``*`` and ``?`` stand for any text and any character within one name; ``[*]``, ``[2:5]`` and a
missing subscript for elements of an array; a last name ``*`` for everything below.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

_PART = re.compile(r"([^.\[\]]+)(?:\[([^\]]*)\])?(\.|$)")
#: Longest range of subscripts that is written out.
LONGEST_RANGE = 10_000


def is_pattern(text: str) -> bool:
    """Return whether a text is a pattern rather than a path."""
    return "*" in text or "?" in text or bool(re.search(r"\[[^\]]*:", text))


@lru_cache(maxsize=256)
def compile_pattern(pattern: str) -> re.Pattern[str] | None:
    """Return the regular expression of a pattern, for ``fullmatch``; None if it can match nothing.

    ``der(...)`` around a pattern asks for derivatives.
    """
    before = after = ""
    while pattern.startswith("der(") and pattern.endswith(")"):
        pattern, before, after = pattern[4:-1], before + r"der\(", r"\)" + after
    parts: list[str] = []
    position = 0
    while position < len(pattern):
        match = _PART.match(pattern, position)
        if match is None or (match[3] == "." and match.end() == len(pattern)):
            return None
        last = match.end() == len(pattern)
        if last and match[1] == "*" and match[2] is None:
            parts.append(".*" if not before else "[^()]*")
        else:
            parts.append(_name(match[1]) + _subscripts(match[2]))
        position = match.end()
    return re.compile(before + r"\.".join(parts) + after) if parts else None


def matching(pattern: str, paths: Iterable[str]) -> list[str]:
    """Return the paths that match, in their order."""
    compiled = compile_pattern(pattern)
    if compiled is None:
        return []
    return [path for path in paths if compiled.fullmatch(path)]


def _name(text: str) -> str:
    any_text, any_character = r"[^.\[\]()]*", r"[^.\[\]()]"
    return "".join(
        any_text if c == "*" else any_character if c == "?" else re.escape(c) for c in text
    )


def _subscripts(text: str | None) -> str:
    if text is None:
        return r"(?:\[[^\]]*\])?"
    return r"\[" + ",".join(_subscript(item.strip()) for item in text.split(",")) + r"[^\]]*\]"


def _subscript(text: str) -> str:
    # A number must not go on: [1] is not [12].
    end = r"(?![0-9])"
    if text in ("*", ":", ""):
        return r"[0-9]+" + end
    low, colon, high = text.partition(":")
    if colon and low.isdecimal() and high.isdecimal() and int(high) - int(low) <= LONGEST_RANGE:
        numbers = "|".join(map(str, range(int(low), int(high) + 1)))
        return f"(?:{numbers}){end}" if numbers else "(?!)"
    return re.escape(text) + end
