"""The component library as Python modules: ``from acausal.library import electrical as el``.

A package is a module, a class in it a Python class with signature and docstring. Nothing is read
before it is used. Folders named in the environment variable ``ACAUSAL_PATH`` are found too.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acausal.modeling.classes import ClassDef
    from acausal.modeling.library import FolderPackage

_PREFIX = __name__ + "."


def _package(name: str) -> FolderPackage | ClassDef | None:
    """Return a package of the library by its dotted name."""
    from acausal.compose.assembly import shared_library
    from acausal.modeling.classes import ClassDef
    from acausal.modeling.library import FolderPackage
    from acausal.modeling.load import library_class

    found = library_class(name, shared_library())
    if isinstance(found, FolderPackage) or (
        isinstance(found, ClassDef) and found.kind == "package"
    ):
        return found
    return None


class _Finder(MetaPathFinder, Loader):
    """Finds packages of the library."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if not fullname.startswith(_PREFIX):
            return None
        package = _package(fullname.removeprefix(_PREFIX))
        if package is None:
            return None
        spec = ModuleSpec(fullname, self, origin=f"library package {package.full_name}")
        spec.submodule_search_locations = []
        return spec

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        from acausal.compose.packages import PackageModule

        package = _package(spec.name.removeprefix(_PREFIX))
        assert package is not None
        return PackageModule(spec.name, package)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: members come when they are asked for."""


sys.meta_path.append(_Finder())


def __getattr__(name: str) -> Any:
    if name[0] == "_":
        raise AttributeError(name)
    if _package(name) is None:
        from acausal.compose.assembly import shared_library
        from acausal.compose.mistakes import unknown_name
        from acausal.compose.places import here

        unknown_name("N150", f"the library has no package {name}", here(), name,
                     shared_library().names(), "acausal list shows the packages")  # fmt: skip
    from importlib import import_module

    return import_module(_PREFIX + name)


def __dir__() -> list[str]:
    from acausal.compose.assembly import shared_library

    return sorted(shared_library().names())
