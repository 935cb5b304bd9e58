"""Parse trees on disk, so that an unchanged file is not parsed twice and Lark not imported.

An entry is keyed by the content of the file and of the modules that make the tree. It is a pickle
that may contain only the node classes of :mod:`acausal.syntax.tree`; anything else is refused on
loading. Spans are stored without the name of their source, which is given back on loading, so a
file may move.

Nodes are pickled in the order children before parents. The pickler then finds every child already
written when it comes to the parent, and never recurses, however deep the tree.
"""

from __future__ import annotations

import gc
import io
import pickle
from collections.abc import Callable
from dataclasses import MISSING, fields
from functools import cache, partial
from hashlib import blake2b
from pathlib import Path
from typing import Any

from acausal.diagnostics.span import Span
from acausal.storage.cache_directory import cache_directory, read, write
from acausal.syntax import tree
from acausal.syntax.source_text import decode, read_bytes

_KIND = "syntax"
_MODULES = (
    "grammar.lark",
    "tree.py",
    "tree_builder.py",
    "class_builder.py",
    "equation_builder.py",
    "expression_builder.py",
    "place_tracking.py",
    "class_assembly.py",
    "precedence.py",
    "source_text.py",
    "cache.py",
)

_NODES: dict[str, type[tree.Node]] = {
    name: value
    for name, value in vars(tree).items()
    if isinstance(value, type) and issubclass(value, tree.Node)
}
_FIELDS = {node: tuple((f.name, f.default) for f in fields(node)) for node in _NODES.values()}


def parse_cached(path: Path | str) -> tree.File:
    """Parse a file, or return its tree from the cache.

    Raises:
        AcausalError: As :func:`acausal.syntax.parser.parse_file`; errors are not cached.
    """
    path = Path(path)
    data = read_bytes(path)
    source = str(path)
    key = None
    if cache_directory() is not None:
        key = content_key(data)
    if key is not None:
        entry = read(_KIND, key)
        if entry is not None:
            known = load_tree(entry, source)
            if known is not None:
                return known
    from acausal.syntax.parser import parse_text

    result = parse_text(decode(data, source), source)
    if key is not None:
        write(_KIND, key, dump_tree(result))
    return result


def content_key(data: bytes) -> str | None:
    """Return the key of a file's content, or None where our own modules cannot be read."""
    stamp = _stamp()
    if stamp is None:
        return None
    return blake2b(stamp + data, digest_size=20).hexdigest()


def dump_tree(root: tree.Node) -> bytes:
    """Return a tree as bytes, without the name of its source."""
    buffer = io.BytesIO()
    _TreePickler(buffer, protocol=5).dump(_children_first(root))
    return buffer.getvalue()


def load_tree(data: bytes, source: str) -> tree.File | None:
    """Return the tree from its bytes; None if they are not those of a file's tree.

    Args:
        data: What :func:`dump_tree` made.
        source: The name of the source in all spans.
    """
    collecting = gc.isenabled()
    gc.disable()  # thousands of objects that live on; looking for cycles among them is in vain
    try:
        nodes = _TreeUnpickler(data, source).load()
    except Exception:  # noqa: BLE001 - a damaged pickle raises anything, and is only missing
        return None
    finally:
        if collecting:
            gc.enable()
    root = nodes[-1] if isinstance(nodes, list) and nodes else None
    return root if isinstance(root, tree.File) else None


@cache
def _stamp() -> bytes | None:
    """Return a hash of everything that decides what tree a text has."""
    here = Path(__file__).parent
    digest = blake2b(digest_size=20)
    try:
        for name in _MODULES:
            digest.update((here / name).read_bytes())
    except OSError:
        return None
    return digest.digest()


def _children_first(root: tree.Node) -> list[tree.Node]:
    """Return all nodes, each behind its children, without recursion."""
    order: list[tree.Node] = []
    stack: list[Any] = [root]
    while stack:
        item = stack.pop()
        if isinstance(item, tuple):
            stack += item
        elif isinstance(item, tree.Node):
            order.append(item)
            for name, _ in _FIELDS[type(item)]:
                value = getattr(item, name)
                if isinstance(value, tuple | tree.Node):
                    stack.append(value)
    order.reverse()
    return order


class _TreePickler(pickle.Pickler):
    """Writes nodes as calls of their classes, and spans without their source."""

    def reducer_override(self, obj: Any) -> Any:
        kind = type(obj)
        if kind is Span:
            return Span, (obj.line, obj.column, obj.end_line, obj.end_column)
        names = _FIELDS.get(kind)
        if names is None:
            return NotImplemented
        arguments = [getattr(obj, name) for name, _ in names]
        for _, default in reversed(names):
            if default is MISSING or arguments[-1] != default:
                break
            arguments.pop()
        return kind, tuple(arguments)


class _TreeUnpickler(pickle.Unpickler):
    """Reads what :class:`_TreePickler` wrote, and knows no other classes."""

    def __init__(self, data: bytes, source: str) -> None:
        super().__init__(io.BytesIO(data))
        self._span: Callable[..., Span] = partial(Span, source)

    def find_class(self, module: str, name: str) -> Any:
        if module == tree.__name__ and name in _NODES:
            return _NODES[name]
        if module == Span.__module__ and name == Span.__name__:
            return self._span
        raise pickle.UnpicklingError(f"{module}.{name} does not belong into a parse tree")
