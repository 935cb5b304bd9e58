"""Packages on disk: a folder is a package, its files only divide it.

Nothing is read before a name in it is asked for, and then only the folder that has the name.
"""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import Path

from acausal.diagnostics import fail
from acausal.modeling.classes import ClassDef, FileScope, Found, Scope
from acausal.modeling.library_path import library_path
from acausal.syntax import tree
from acausal.syntax.cache import parse_cached

SUFFIX = ".acm"


class FolderPackage:
    """A folder as a package. Its members are the classes of its files and its sub-folders."""

    def __init__(self, path: Path, parent: Scope) -> None:
        self.path = path
        self._parent = parent

    def __repr__(self) -> str:
        return f"FolderPackage({self.full_name})"

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.path.name

    @property
    def full_name(self) -> str:
        """Dotted name from the library's root."""
        outer = self._parent.full_name
        return f"{outer}.{self.path.name}" if outer else self.path.name

    @property
    def parent(self) -> Scope | None:
        """The package around it."""
        return self._parent

    @cached_property
    def files(self) -> list[Path]:
        """The source files, sorted by name."""
        return sorted(p for p in self.path.iterdir() if p.suffix == SUFFIX and p.is_file())

    @cached_property
    def packages(self) -> dict[str, FolderPackage]:
        """The sub-packages."""
        return {
            p.name: FolderPackage(p, self)
            for p in sorted(self.path.iterdir())
            if p.is_dir() and p.name.isidentifier() and not p.name.startswith("_")
        }

    @cached_property
    def classes(self) -> dict[str, ClassDef]:
        """The classes of all files, in file order.

        Raises:
            AcausalError: ``N105`` when two files declare the same name.
        """
        result: dict[str, ClassDef] = {}
        for path in self.files:
            root_of(self).sources.append(path)
            for name, definition in classes_of(parse_cached(path), self).items():
                if name in result:
                    fail(
                        "N105",
                        f"{name} is declared twice in package {self.full_name}",
                        definition.span,
                        help="rename one of the two",
                    )
                result[name] = definition
        return result

    def find(self, name: str) -> Found | None:
        """Return a sub-package or a class."""
        return self.packages.get(name) or self.classes.get(name)

    def names(self) -> list[str]:
        """Names of sub-packages and classes."""
        return [*self.packages, *self.classes]


class Root:
    """The unnamed outermost package: the folders and single-file packages of the library path."""

    def __init__(self, folders: list[Path]) -> None:
        self.folders = folders
        #: Files read so far, in order.
        self.sources: list[Path] = []
        self._files: dict[str, ClassDef | None] = {}

    @property
    def full_name(self) -> str:
        """Empty."""
        return ""

    @property
    def parent(self) -> Scope | None:
        """None: nothing is around it."""
        return None

    @cached_property
    def packages(self) -> dict[str, FolderPackage]:
        """The top-level packages; the first folder of the path wins."""
        result: dict[str, FolderPackage] = {}
        for folder in self.folders:
            if not folder.is_dir():
                continue
            for p in sorted(folder.iterdir()):
                if p.is_dir() and p.name.isidentifier() and p.name not in result:
                    result[p.name] = FolderPackage(p, self)
        return result

    def find(self, name: str) -> Found | None:
        """Return a top-level package, from a folder or from a file of its name."""
        if name in self.packages:
            return self.packages[name]
        if name not in self._files:
            self._files[name] = self._single_file(name)
        return self._files[name]

    def _single_file(self, name: str) -> ClassDef | None:
        for folder in self.folders:
            path = folder / (name + SUFFIX)
            if path.is_file():
                self.sources.append(path)
                return classes_of(parse_cached(path), self).get(name)
        return None

    def names(self) -> list[str]:
        """Names of all top-level packages."""
        files = [p.stem for f in self.folders if f.is_dir() for p in sorted(f.glob("*" + SUFFIX))]
        return [*self.packages, *files]


def root_of(scope: Scope) -> Root:
    """Return the outermost package around a scope."""
    while scope.parent is not None:
        scope = scope.parent
    assert isinstance(scope, Root)
    return scope


def classes_of(file: tree.File, package: Scope) -> dict[str, ClassDef]:
    """Return the classes of one file by name, in order.

    Raises:
        AcausalError: ``N105`` when the file declares a name twice.
    """
    scope = FileScope(file.imports, package)
    for definition in file.classes:
        if definition.name in scope.classes:
            fail(
                "N105",
                f"{definition.name} is declared twice",
                definition.span,
                help="rename one of the two",
            )
        scope.classes[definition.name] = ClassDef(definition, scope)
    return scope.classes


def standard_library(extra: tuple[Path, ...] = ()) -> Root:
    """Return the root package.

    Args:
        extra: Further folders that hold packages, searched after the library itself. The
            environment variable ``ACAUSAL_PATH`` adds more, separated as in ``PATH``.
    """
    listed = os.environ.get("ACAUSAL_PATH", "").split(os.pathsep)
    return Root([library_path(), *extra, *(Path(p) for p in listed if p)])
