"""Files to classes: which classes a file declares, and which of them is the model to run."""

from __future__ import annotations

from pathlib import Path

from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import ClassDef
from acausal.modeling.library import FolderPackage, Root, classes_of, standard_library
from acausal.syntax.cache import parse_cached

#: Kinds of classes that can be simulated.
RUNNABLE = ("model", "block", "class")


def load_file(path: Path) -> tuple[dict[str, ClassDef], Root]:
    """Return the classes of a file by name, and the library they see.

    Packages in the file's own folder can be imported too.

    Raises:
        AcausalError: For a file that cannot be read or parsed.
    """
    file = parse_cached(path)
    root = standard_library((path.resolve().parent,))
    package: object = library_class(".".join(file.within), root) if file.within else root
    inside = package if isinstance(package, FolderPackage) else root
    return classes_of(file, inside), root


def load_text(text: str, source: str = "<text>") -> tuple[dict[str, ClassDef], Root]:
    """Return the classes of a text by name, and the library they see.

    Raises:
        AcausalError: For a text that cannot be parsed.
    """
    from acausal.syntax.parser import parse_text

    root = standard_library()
    return classes_of(parse_text(text, source), root), root


def choose_model(classes: dict[str, ClassDef], name: str | None, where: str) -> ClassDef:
    """Return the model called ``name``, or the last model of a file.

    Args:
        classes: The classes of the file.
        name: A class name, dotted for one inside a package; None for the last model.
        where: The file, for messages.

    Raises:
        AcausalError: ``F105`` if there is no such model, ``N111`` if it is partial.
    """
    if name is None:
        models = [c for c in classes.values() if c.kind in RUNNABLE and not c.tree.partial]
        if not models:
            fail("F105", f"{where} declares no model that can be simulated",
                 help="declare a model that is not partial")  # fmt: skip
        return models[-1]
    parts = name.split(".")
    found = classes.get(parts[0])
    for part in parts[1:]:
        found = found.classes.get(part) if found is not None else None
    if found is None:
        known = [c for c, d in classes.items() if d.kind in RUNNABLE]
        close = nearest(name, known) or known[:8]
        fail("F105", f"{where} has no model {name}",
             notes=[f"it has {', '.join(known)}"] if known else [],
             help=f"name one of them, for example {close[0]}" if close
             else "declare a model in it")  # fmt: skip
    if found.tree.partial:
        fail("N111", f"{name} is partial and cannot be simulated", found.span,
             help="simulate a model that extends it")  # fmt: skip
    if found.kind not in RUNNABLE:
        fail("F105", f"{name} is a {found.kind}, not a model", found.span,
             help="name a model or block")  # fmt: skip
    return found


def library_class(name: str, root: Root | None = None) -> object:
    """Return a package or class of the library by its dotted name, or None."""
    root = root or standard_library()
    found: object = root
    for part in name.split(".") if name else []:
        if isinstance(found, ClassDef):
            found = found.member(part)
        elif hasattr(found, "find"):
            found = found.find(part)
        else:
            return None
    return found
