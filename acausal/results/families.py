"""Variables that differ only in their subscripts, taken together as one array.

``link[1].angle ... link[1000].angle`` is one array ``link[*].angle`` of shape ``(nt, 1000)``. With
one object a scalar, files and data sets of a large model would take minutes to write.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from acausal.results.result import VariableSource

_SUBSCRIPTS = re.compile(r"\[[^\]]*\]")


@dataclass(frozen=True, slots=True)
class Family:
    """Variables stored as one array.

    Attributes:
        name: The path of a single variable, or a pattern that its members match.
        paths: The members.
        unit: Their unit.
        description: Their description string.
    """

    name: str
    paths: tuple[str, ...]
    unit: str
    description: str

    @property
    def single(self) -> bool:
        """Whether it is a variable by itself."""
        return len(self.paths) == 1

    @property
    def labels(self) -> str:
        """Name of the dimension (and of its coordinate) that holds the members' paths."""
        return f"paths of {self.name}"


def families(paths: Sequence[str], source: VariableSource) -> list[Family]:
    """Group paths by what is left when their subscripts are taken away, in order of first sight.

    Members of unlike unit stay by themselves.
    """
    grouped: dict[tuple[str, str], list[str]] = {}
    for path in paths:
        pattern = _SUBSCRIPTS.sub("[*]", path)
        grouped.setdefault((pattern, source.unit(path)), []).append(path)
    result: list[Family] = []
    taken: set[str] = set()
    for (pattern, unit), members in grouped.items():
        if len(members) > 1 and pattern not in taken:
            taken.add(pattern)
            about = source.description(members[0])
            result.append(Family(pattern, tuple(members), unit, about))
        else:
            result += [Family(p, (p,), unit, source.description(p)) for p in members]
    return result
