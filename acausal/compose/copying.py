"""Copies of models, to be changed independently of the original."""

from __future__ import annotations

import copy
from typing import Any

from acausal.compose.places import here


def copied(model: Any, memo: dict[int, Any]) -> Any:
    """Return a copy of a component and everything in it; nothing else is copied."""
    cls = type(model)
    twin = object.__new__(cls)
    memo[id(model)] = twin
    for name in _slots(cls):
        if not hasattr(model, name):
            continue
        value = getattr(model, name)
        if name == "_frozen":
            value = None
        elif name == "_owner":
            value = memo.get(id(value), value if isinstance(value, type) else None)
        elif name not in ("_span", "_compiled"):
            value = copy.deepcopy(value, memo)
        elif name == "_compiled":
            value = {}
        object.__setattr__(twin, name, value)
    for name, value in getattr(model, "__dict__", {}).items():
        object.__setattr__(twin, name, copy.deepcopy(value, memo))
    return twin


def copy_of(model: Any) -> Any:
    """Return a copy of a model that belongs to nobody and is not compiled."""
    twin = copied(model, {id(model._owner): None} if model._owner is not None else {})
    object.__setattr__(twin, "_owner", None)
    object.__setattr__(twin, "_name", "")
    object.__setattr__(twin, "_span", here())
    return twin


def _slots(cls: type) -> list[str]:
    found: list[str] = []
    for base in reversed(cls.__mro__):
        slots = base.__dict__.get("__slots__", ())
        found += [slots] if isinstance(slots, str) else list(slots)
    return found
