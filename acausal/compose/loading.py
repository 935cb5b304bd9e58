"""Classes of a file of the language for use in Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from acausal.compose.assembly import shared_library
from acausal.compose.mistakes import unknown_name
from acausal.compose.places import here
from acausal.compose.text_classes import python_object
from acausal.modeling.classes import ClassDef
from acausal.modeling.library import FolderPackage, Root, classes_of
from acausal.modeling.load import library_class


class LoadedFile:
    """The classes of a file as attributes, see :func:`load`."""

    def __init__(self, path: Path, classes: dict[str, ClassDef]) -> None:
        self._path = path
        self._classes = classes
        self.__name__ = path.stem
        self.__doc__ = "\n".join(
            f"{name}: {c.tree.description}" if c.tree.description else name
            for name, c in classes.items()
        )

    def __repr__(self) -> str:
        return f"<{self._path.name}: {', '.join(self._classes)}>"

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_":
            raise AttributeError(name)
        found = self._classes.get(name)
        if found is None:
            unknown_name("N150", f"{self._path.name} has no class {name}", here(), name,
                         self._classes, f"it has {', '.join(self._classes)}")  # fmt: skip
        return python_object(found, self.__name__)

    def __dir__(self) -> list[str]:
        return sorted(self._classes)


def load(path: str | Path) -> LoadedFile:
    """Load the classes of a file, to be used as those of the library.

    Args:
        path: The file. Packages in its folder can be imported by it.

    Returns:
        An object with the classes as attributes.

    Raises:
        AcausalError: For a file that cannot be read or parsed.

    Example:
        >>> import acausal as ac
        >>> parts = ac.load("examples/rlc.acm")
        >>> board = ac.Model("board")
        >>> board.circuit = parts.RLC()
    """
    from acausal.syntax.cache import parse_cached

    file = Path(path)
    syntax = parse_cached(file)
    library = shared_library()
    root = Root([*library.folders, file.resolve().parent])
    root.packages = {**root.packages, **library.packages}
    # Single files are packages too; all models share one copy of each class of the library.
    root._files = library._files
    package: object = library_class(".".join(syntax.within), root) if syntax.within else root
    inside = package if isinstance(package, FolderPackage) else root
    return LoadedFile(file, classes_of(syntax, inside))
