"""How an error is shown in a notebook: the user's own lines, then the message."""

from __future__ import annotations

import contextlib
import sys
import traceback
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from acausal.diagnostics.diagnostic import AcausalError

#: Frames of these files are ours; contextlib stands between them where we use decorators.
_OURS = (str(Path(__file__).parents[1]), contextlib.__file__)


def own_frames(entry: TracebackType | None) -> TracebackType | None:
    """Return a traceback without the frames inside of acausal, which tell a user nothing."""
    kept = []
    while entry is not None:
        if not entry.tb_frame.f_code.co_filename.startswith(_OURS):
            kept.append(entry)
        entry = entry.tb_next
    shown = None
    for entry in reversed(kept):
        shown = TracebackType(shown, entry.tb_frame, entry.tb_lasti, entry.tb_lineno)
    return shown


def rendered(error: AcausalError) -> list[str]:
    """Return what a notebook prints for an error, as lines: the user's frames and the message."""
    own = own_frames(error.__traceback__)
    shell = _shell()
    if shell is None:
        frames = traceback.extract_tb(own)[-1:]
        return [*"".join(traceback.format_list(frames)).splitlines(), *str(error).splitlines()]
    if error.__cause__ is None:
        error.__suppress_context__ = True  # a KeyError of ours behind a message of ours
    lines: list[str] = shell.InteractiveTB.structured_traceback(
        type(error), error, own, tb_offset=1
    )
    # A cell is stored under a name of its own; a user knows its number.
    for source in dict.fromkeys(d.span.source for d in error.diagnostics if d.span is not None):
        name = shell.compile.format_code_name(source)
        if name is not None:
            lines = [line.replace(source, " ".join(name)) for line in lines]
    return lines


def _shell() -> Any:
    if "IPython" not in sys.modules:
        return None
    from IPython import get_ipython

    return get_ipython()
