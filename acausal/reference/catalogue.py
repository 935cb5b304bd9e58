"""Which packages and classes there are, and what is said about a package as a whole."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from acausal.diagnostics import fail
from acausal.diagnostics.suggest import nearest
from acausal.modeling.classes import ClassDef
from acausal.modeling.library import FolderPackage, Root
from acausal.modeling.library_path import library_path
from acausal.modeling.load import library_class


@dataclass(frozen=True)
class Package:
    """A package with classes of its own.

    Attributes:
        name: Full name.
        classes: Its classes in the order of the files.
        constants: The package as a class, if it is one that holds constants.
        overview: Paragraphs about it, in simple Markdown.
    """

    name: str
    classes: tuple[ClassDef, ...]
    constants: ClassDef | None
    overview: tuple[str, ...]


def packages(root: Root, names: Sequence[str] = ()) -> list[Package]:
    """Return the packages of the library that have classes, outer ones before inner ones.

    Args:
        root: The library.
        names: Only these packages and those inside of them; all if empty.

    Raises:
        AcausalError: ``N150`` if there is no package of a name.
    """
    for name in names:
        if not isinstance(library_class(name, root), (FolderPackage, ClassDef)):
            close = nearest(name, _package_names(root))
            fail("N150", f"the library has no package {name}",
                 notes=[f"did you mean {' or '.join(close)}?"] if close else [],
                 help="acausal list shows the packages")  # fmt: skip
    found = list(_packages(root))
    if not names:
        return found
    return [p for p in found if any(p.name == n or p.name.startswith(n + ".") for n in names)]


def _package_names(root: Root) -> list[str]:
    """Return the names of all packages, without reading a file."""
    names: list[str] = []
    pending = list(root.packages.values())
    while pending:
        package = pending.pop(0)
        names.append(package.full_name)
        pending += package.packages.values()
    return names


def all_classes(root: Root) -> Iterator[ClassDef]:
    """Yield every class of the library, those inside of classes too."""
    for package in _packages(root):
        pending = list(reversed(package.classes))
        while pending:
            definition = pending.pop()
            yield definition
            pending += reversed(definition.classes.values())


def _packages(root: Root) -> Iterator[Package]:
    pending: list[object] = [root.find(name) for name in dict.fromkeys(root.names())]
    pending.reverse()
    while pending:
        package = pending.pop()
        if isinstance(package, FolderPackage):
            classes = tuple(c for c in package.classes.values() if c.kind != "package")
            if classes:
                yield Package(package.full_name, classes, None, _overview(package))
            inner: list[object] = list(package.packages.values())
            inner += [c for c in package.classes.values() if c.kind == "package"]
            pending += reversed(inner)
        elif isinstance(package, ClassDef) and package.kind == "package":
            about = (package.tree.description,) if package.tree.description else ()
            yield Package(package.full_name, tuple(package.classes.values()), package, about)


def _overview(package: FolderPackage) -> tuple[str, ...]:
    """Return the first paragraphs of the page of the manual about a package, if it has one."""
    docs = library_path().parent / "docs"
    name = package.full_name
    for stem in (name, name.replace(".", "-"), name.rpartition(".")[2]):
        page = docs / f"{stem}.md"
        if page.is_file():
            return _first_paragraphs(page)
    return ()


def _first_paragraphs(page: Path) -> tuple[str, ...]:
    text = page.read_text(encoding="utf-8")
    paragraphs: list[str] = []
    for block in re.split(r"\n\s*\n", text):
        block = block.strip()
        if block.startswith("# "):
            block = block.partition("\n")[2].strip()
        if not block:
            continue
        if block[0] in "#|`![-<" or len(paragraphs) == 2:
            break
        paragraphs.append(" ".join(block.split()))
    return tuple(paragraphs)
