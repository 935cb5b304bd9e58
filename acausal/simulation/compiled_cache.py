"""Compiled models on disk, so that a second run neither parses nor analyses anything.

An entry is found by the absolute path of the file, the model and the given parameters, and is valid
while every source file that went into it has the same content, no file has come to or gone from the
packages it used, and acausal itself is the same.
"""

from __future__ import annotations

import io
import pickle
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

from acausal.diagnostics import Diagnostic
from acausal.simulation.system import System
from acausal.storage import cache_directory
from acausal.version import __version__

_KIND = "model"
#: Larger entries would take longer to write than they save.
_LARGEST = 200_000_000
_BUILTINS = ("builtins.tuple", "builtins.set", "builtins.frozenset", "builtins.slice",
             "collections.OrderedDict")  # fmt: skip

Entry = tuple[System, tuple[Diagnostic, ...]]


class _Unpickler(pickle.Unpickler):
    """Admits our own records and arrays, nothing that could act."""

    def find_class(self, module: str, name: str) -> Any:
        full = f"{module}.{name}"
        if full in _BUILTINS or (
            module.split(".")[0] == "numpy"
            and name in ("ndarray", "dtype", "_reconstruct", "scalar", "_frombuffer")
        ):
            return super().find_class(module, name)
        if module.startswith("acausal."):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(full)


@cache
def _own_code() -> bytes:
    """Return a hash of acausal's own files: names, sizes and times."""
    root = Path(__file__).resolve().parent.parent
    digest = blake2b(__version__.encode())
    for path in sorted(root.rglob("*.py")):
        status = path.stat()
        digest.update(f"{path.name} {status.st_size} {status.st_mtime_ns};".encode())
    return digest.digest()


def _key(path: Path, model: str | None, given: Mapping[str, float]) -> str:
    text = repr((str(path.resolve()), model, sorted(given.items())))
    return blake2b(text.encode() + _own_code(), digest_size=20).hexdigest()


def _state_of(sources: Sequence[Path]) -> list[tuple[str, bytes]]:
    """Return the content hashes of files, and the listings of the folders they stand in."""
    result = []
    folders = dict.fromkeys(p.parent for p in sources[1:])
    for path in dict.fromkeys(sources):
        result.append((str(path), blake2b(path.read_bytes(), digest_size=20).digest()))
    for folder in folders:
        names = "\n".join(sorted(p.name for p in folder.iterdir()))
        result.append((str(folder), blake2b(names.encode(), digest_size=20).digest()))
    return result


def _unchanged(state: list[tuple[str, bytes]]) -> bool:
    for name, digest in state:
        path = Path(name)
        try:
            if path.is_dir():
                content = "\n".join(sorted(p.name for p in path.iterdir())).encode()
            else:
                content = path.read_bytes()
        except OSError:
            return False
        if blake2b(content, digest_size=20).digest() != digest:
            return False
    return True


def recall(path: Path, model: str | None, given: Mapping[str, float]) -> Entry | None:
    """Return a compiled model that is still valid, or None."""
    if cache_directory.cache_directory() is None:
        return None
    data = cache_directory.read(_KIND, _key(path, model, given))
    if data is None:
        return None
    try:
        state, entry = _Unpickler(io.BytesIO(data)).load()
        if not _unchanged(state):
            return None
        return entry  # type: ignore[no-any-return]
    except Exception:  # noqa: BLE001 - whatever is wrong with an entry, it is made anew
        return None


def remember(
    path: Path, model: str | None, given: Mapping[str, float], sources: Sequence[Path], entry: Entry
) -> None:
    """Store a compiled model; do nothing if that is not possible."""
    if cache_directory.cache_directory() is None:
        return
    # A model takes some ten times as much as these numbers: do not make what is thrown away.
    if 10 * entry[0].representative.nbytes > _LARGEST:
        return
    try:
        data = pickle.dumps((_state_of(sources), entry), protocol=5)
    except (OSError, RecursionError):
        return
    if len(data) <= _LARGEST:
        cache_directory.write(_KIND, _key(path, model, given), data)
