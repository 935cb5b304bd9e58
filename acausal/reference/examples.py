"""Which models use which classes of the library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from acausal.diagnostics import AcausalError
from acausal.modeling.classes import ClassDef, find_name
from acausal.modeling.load import load_file


def used_by_files(files: Iterable[Path]) -> dict[str, list[str]]:
    """Return, for every class of the library, the names of the files whose models use it.

    Args:
        files: Files with models; what cannot be read is left out.
    """
    used: dict[str, list[str]] = {}
    for path in sorted(files):
        try:
            classes = load_file(path)[0].values()
            names = {c.full_name for model in classes for c in used_classes(model)}
        except AcausalError:
            continue
        for name in names:
            used.setdefault(name, []).append(path.name)
    return used


def used_classes(definition: ClassDef) -> Iterator[ClassDef]:
    """Yield the classes that a class names: of its components, its bases, and of classes in it.

    Raises:
        AcausalError: If a base class is not found, or a name is ambiguous.
    """
    for base, _ in definition.bases:
        if isinstance(base, ClassDef):
            yield base
    for component in definition.tree.components:
        found = find_name(definition, component.type_name, skip_components=True)
        if isinstance(found, ClassDef):
            yield found
    for inner in definition.classes.values():
        yield from used_classes(inner)
