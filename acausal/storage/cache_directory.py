"""Where the cache is, and safe reading and writing of its entries.

The cache only ever saves time. Whatever is wrong with it (no space, no permission, a file cut
short, a file of another user) reads as a missing entry, and a failed write is no failure.

The folder is ``$ACAUSAL_CACHE`` if that is set (empty or ``off``: no cache), else
``$XDG_CACHE_HOME/acausal``, else ``~/.cache/acausal``. An entry is trusted, because kernels are
executed, only if it and its folders belong to the user and nobody else can write them.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
from hashlib import blake2b
from pathlib import Path

_MAGIC = b"acausal cache 1\n"
_DIGEST_BYTES = 32
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,127}")


def cache_directory() -> Path | None:
    """Return the cache folder, made if it was not there; None if there is no usable one."""
    setting = os.environ.get("ACAUSAL_CACHE")
    if setting is not None:
        if setting.strip().lower() in ("", "off"):
            return None
        folder = Path(os.path.abspath(setting))
    else:
        base = os.environ.get("XDG_CACHE_HOME", "")
        try:
            # The specification says to ignore a relative path here.
            root = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
        except RuntimeError:
            return None
        folder = root / "acausal"
    return folder if _private_folder(folder) else None


def read(kind: str, key: str) -> bytes | None:
    """Return an entry of the cache, or None if there is none that can be trusted.

    Args:
        kind: The sort of entry, a subfolder: ``syntax``, ``kernel`` and so on.
        key: The name of the entry; a hash of everything its content depends on.
    """
    path = _entry(kind, key)
    if path is None:
        return None
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | _BINARY)
        with os.fdopen(descriptor, "rb") as stream:
            status = os.fstat(stream.fileno())
            if not stat.S_ISREG(status.st_mode) or not _mine(status):
                return None
            content = stream.read()
    except (OSError, ValueError, MemoryError):
        return None
    head = len(_MAGIC) + _DIGEST_BYTES
    data = content[head:]
    if content[:head] != _MAGIC + _digest(data):
        return None
    return data


def write(kind: str, key: str, data: bytes) -> None:
    """Put an entry into the cache; do nothing if that is not possible.

    The entry appears whole or not at all, also with several writers at once.
    """
    path = _entry(kind, key)
    if path is None:
        return
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{os.urandom(4).hex()}")
    try:
        descriptor = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o600)
    except (OSError, ValueError):
        return
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(_MAGIC + _digest(data))
            stream.write(data)
        os.replace(temporary, path)
    except (OSError, ValueError):
        with contextlib.suppress(OSError):
            os.unlink(temporary)


_BINARY: int = getattr(os, "O_BINARY", 0)


def _digest(data: bytes) -> bytes:
    return blake2b(data, digest_size=_DIGEST_BYTES).digest()


def _entry(kind: str, key: str) -> Path | None:
    """Return the path of an entry, its folder made and checked.

    Raises:
        ValueError: A name that could leave the folder.
    """
    for name in (kind, key):
        if not _NAME.fullmatch(name):
            raise ValueError(f"not a name for a cache entry: {name!r}")
    folder = cache_directory()
    if folder is None or not _private_folder(folder / kind):
        return None
    return folder / kind / key


def _private_folder(folder: Path) -> bool:
    """Make the folder if needed; tell whether only this user can write to it."""
    try:
        try:
            status = os.stat(folder)
        except FileNotFoundError:
            folder.parent.mkdir(parents=True, exist_ok=True)
            folder.mkdir(mode=0o700, exist_ok=True)
            status = os.stat(folder)
        return stat.S_ISDIR(status.st_mode) and _mine(status)
    except (OSError, ValueError):
        return False


def _mine(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):  # Windows: the profile folder is private by its own rules
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o022
