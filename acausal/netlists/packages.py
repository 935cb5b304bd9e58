"""Packages of the library, known by name only when a netlist is read."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def package(name: str) -> Any:
    """Return a package of the library as a module, for example ``package("electrical.spice")``."""
    return import_module(f"acausal.library.{name}" if name else "acausal.library")
