"""Identifiers made of names that are none."""

from __future__ import annotations

import re

from acausal.compose.names import RESERVED


def identifier(text: str, prefix: str) -> str:
    """Return a name with letters, digits and ``_`` only.

    Args:
        text: Any text; a reserved word of the language gets a ``_`` behind it.
        prefix: Put before what would not begin with a letter.

    Example:
        >>> identifier("net-3", "n"), identifier("(0, 1)", "n"), identifier("3", "n")
        ('net_3', 'n0_1', 'n3')
    """
    name = re.sub(r"[^A-Za-z0-9]+", "_", text.replace("+", "p")).strip("_")
    name = name if name[:1].isalpha() else f"{prefix}{name}"
    return f"{name}_" if name in RESERVED else name
