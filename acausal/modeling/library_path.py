"""Where the component library lies."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent.parent


@lru_cache(maxsize=1)
def library_path() -> Path:
    """Return the folder of the component library.

    An installed package carries it inside (``acausal/_library``); a source tree has it at the
    top (``library``).

    Raises:
        AcausalError: ``F120`` if neither is there.
    """
    for folder in (_PACKAGE / "_library", _PACKAGE.parent / "library"):
        if folder.is_dir():
            return folder
    from acausal.diagnostics import fail

    fail(
        "F120",
        "the component library is missing from this installation",
        notes=[f"looked in {_PACKAGE / '_library'} and {_PACKAGE.parent / 'library'}"],
        help="install acausal again, or run it from a complete source tree",
    )
