"""Every class of the library can be used, is described, and gives its parameters values."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from acausal.flattening.flatten import flatten
from acausal.instantiation.instantiate import instantiate
from acausal.modeling.classes import ClassDef
from acausal.modeling.library import FolderPackage, standard_library
from acausal.modeling.load import load_text

#: What the components of a package need around them.
SURROUNDINGS = {
    "mechanical.planar.": "inner mechanical.planar.PlanarWorld world;",
    "hydraulic.": "inner hydraulic.Oil oil;",
    "pneumatic.": "inner pneumatic.Gas gas;",
}


def walk(package: FolderPackage) -> Iterator[ClassDef]:
    yield from package.classes.values()
    for inner in package.packages.values():
        yield from walk(inner)


CLASSES = [c for package in standard_library().packages.values() for c in walk(package)]
COMPONENTS = [
    c.full_name
    for c in CLASSES
    if c.tree.kind in ("model", "block") and not c.tree.partial and c.full_name[0] != "_"
]


def test_there_is_a_library() -> None:
    assert len(COMPONENTS) > 200


@pytest.mark.parametrize("name", COMPONENTS)
def test_component_can_be_used(name: str) -> None:
    around = "".join(part for start, part in SURROUNDINGS.items() if name.startswith(start))
    text = f"model Alone\n  {around}\n  {name} component_;\nend Alone;\n"
    classes, _ = load_text(text)
    templates, left = instantiate(classes["Alone"])
    flat = flatten(templates, left)
    assert flat is not None


def test_everything_is_described() -> None:
    silent = [c.full_name for c in CLASSES if not c.tree.description and c.tree.kind != "type"]
    for c in CLASSES:
        if c.tree.kind in ("model", "block", "connector", "record", "function"):
            silent += [
                f"{c.full_name}.{part.name}"
                for part in c.tree.components
                if not part.description and "outer" not in part.prefixes
            ]
    assert silent == []


def test_parameters_have_values() -> None:
    empty = [
        f"{c.full_name}.{part.name}"
        for c in CLASSES
        for part in c.tree.components
        if "parameter" in part.prefixes
        and part.value is None
        and not any(change.name == ("fixed",) for change in part.modifiers)
    ]
    assert empty == []


def test_no_equation_is_written_twice() -> None:
    # What two classes have in common belongs in a partial class that both extend.
    seen: dict[str, str] = {}
    for c in CLASSES:
        if c.tree.kind not in ("model", "block") or len(c.tree.equations) < 4:
            continue
        text = "|".join(sorted(_without_places(repr(e)) for e in c.tree.equations))
        assert text not in seen, f"{c.full_name} and {seen[text]}"
        seen[text] = c.full_name


def _without_places(text: str) -> str:
    import re

    return re.sub(r"Span\([^)]*\)", "", re.sub(r"description='[^']*'", "", text))
