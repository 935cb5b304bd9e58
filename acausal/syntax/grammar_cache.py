"""The tables of the LALR parser on disk: computing them takes longer than parsing most files.

The tables are plain dictionaries, lists, strings and numbers; loading refuses everything else.
"""

from __future__ import annotations

import io
import pickle
import sys
from functools import cache
from hashlib import blake2b
from typing import TYPE_CHECKING, Any, NoReturn, cast

from acausal.storage.cache_directory import read, write

if TYPE_CHECKING:
    from collections.abc import Callable

    from lark import Lark

_KIND = "grammar"


def load_tables(grammar: str, transformer: Any) -> Lark | None:
    """Return the parser for the grammar from the cache, or None."""
    from lark import Lark

    data = read(_KIND, _key(grammar))
    if data is None:
        return None
    try:
        tables = _PlainUnpickler(io.BytesIO(data)).load()
        load = cast("Callable[..., Lark]", Lark._load_from_dict)
        return load(tables["data"], tables["memo"], transformer=transformer)
    except Exception:  # noqa: BLE001 - a damaged entry raises anything, and is only a missing one
        return None


def save_tables(lark: Lark, grammar: str) -> None:
    """Put the parser's tables into the cache, if that is possible."""
    buffer = io.BytesIO()
    lark.save(buffer, exclude_options=("transformer",))
    write(_KIND, _key(grammar), buffer.getvalue())


@cache
def _key(grammar: str) -> str:
    import lark

    stamp = f"{lark.__version__} {sys.version_info[:2]} {grammar}"
    return blake2b(stamp.encode(), digest_size=20).hexdigest()


class _PlainUnpickler(pickle.Unpickler):
    def find_class(self, module: str, name: str) -> NoReturn:
        raise pickle.UnpicklingError(f"{module}.{name} does not belong into parser tables")
