"""Which two cuts of a component are its beginning and its end."""

from __future__ import annotations

from typing import Any

#: Names of beginning and end in the library, usual ones first.
PAIRS = (
    ("p", "n"),
    ("flange_a", "flange_b"),
    ("port_a", "port_b"),
    ("frame_a", "frame_b"),
    ("port_p", "port_n"),
    ("plug_p", "plug_n"),
    ("flowPort_a", "flowPort_b"),
    ("pivot", "tip"),
    ("hinge_a", "hinge_b"),
    ("pin_p", "pin_n"),
    ("pin_a", "pin_b"),
)


def cuts_of(kind: Any) -> list[str]:
    """Return the names of the cuts of a class, without signals."""
    found = []
    for name in kind.names():
        member = kind.member(name)
        if member is not None and member.kind.is_connector and not member.kind.primitive:
            found.append(name)
    return found


def cut_pair(kind: Any) -> tuple[str, str] | None:
    """Return the beginning and the end of a component, or None if it is not plain.

    They are those with usual names (``p`` and ``n``, ``flange_a`` and ``flange_b``, ...), or the
    only two.
    """
    cuts = cuts_of(kind)
    for first, last in PAIRS:
        if first in cuts and last in cuts:
            return first, last
    return (cuts[0], cuts[1]) if len(cuts) == 2 else None


def single_cut(kind: Any) -> str | None:
    """Return the cut of a component with one, or the beginning of one with two."""
    cuts = cuts_of(kind)
    if len(cuts) == 1:
        return cuts[0]
    pair = cut_pair(kind)
    if pair is not None:
        return pair[0]
    usual = [c for pair in PAIRS for c in pair if c in cuts]
    usual += [c for c in ("port", "flange", "frame", "pin", "cut") if c in cuts]
    return usual[0] if len(usual) == 1 else None
