"""Packages of the library as modules: nothing is read before a name in it is asked for."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from acausal.compose.mistakes import unknown_name
from acausal.compose.places import here
from acausal.compose.text_classes import python_object
from acausal.modeling.classes import Builtin, ClassDef
from acausal.modeling.classes import Constant as ClassConstant
from acausal.modeling.library import FolderPackage


class PackageModule(ModuleType):
    """A folder of the library, or a file that holds one package, as a module."""

    def __init__(self, name: str, package: FolderPackage | ClassDef) -> None:
        super().__init__(name)
        self._package = package

    @property
    def __doc__(self) -> str:  # type: ignore[override]
        from acausal.modeling.listing import describe

        return describe(self._package.full_name)

    def __repr__(self) -> str:
        return f"<library package {self._package.full_name}>"

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_" or "_package" not in self.__dict__:
            raise AttributeError(name)
        value = member_of(self._package, name, self.__name__)
        self.__dict__[name] = value
        return value

    def __dir__(self) -> list[str]:
        return sorted(self._package.names())


class ClassPackage:
    """A package that is a class inside of a file."""

    def __init__(self, definition: ClassDef, module: str) -> None:
        self._definition = definition
        self._module = module
        self.__name__ = definition.name
        self.__doc__ = definition.tree.description

    def __repr__(self) -> str:
        return f"<package {self._definition.full_name}>"

    def __getattr__(self, name: str) -> Any:
        if name[0] == "_":
            raise AttributeError(name)
        return member_of(self._definition, name, self._module)

    def __dir__(self) -> list[str]:
        return sorted(self._definition.names())


def member_of(package: FolderPackage | ClassDef, name: str, module: str) -> Any:
    """Return a member of a package as Python sees it.

    Raises:
        UnknownNameError: ``N150`` if it has none of the name.
    """
    found = package.find(name)
    if isinstance(found, FolderPackage):
        from importlib import import_module

        return import_module(f"{module}.{name}")
    if (
        found is None
        or isinstance(found, Builtin)
        or not isinstance(found, ClassDef | ClassConstant)
    ):
        unknown_name("N150", f"{package.full_name} has no {name}", here(), name, package.names(),
                     f"acausal list {package.full_name} shows what it has")  # fmt: skip
    return python_object(found, module)
