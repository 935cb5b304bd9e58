"""Result files: the suffix chooses the format, and a file is there whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from acausal.diagnostics import fail

if TYPE_CHECKING:
    from acausal.results.result import Result

Writer = Callable[["Result", Sequence[str], Path], None]
Reader = Callable[[Path], "Result"]

#: What may stand behind ``--output``.
SUFFIXES = (".csv", ".nc", ".h5", ".hdf5", ".parquet")


def check_suffix(path: str | os.PathLike[str], suffixes: Sequence[str] = SUFFIXES) -> str:
    """Return the lower-case suffix of a file that is to be written or read.

    Raises:
        AcausalError: ``F201`` if it is none of ``suffixes``.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in suffixes:
        fail(
            "F201",
            f"the suffix of '{os.fspath(path)}' tells no known file format",
            help=f"end the name in {', '.join(suffixes[:-1])} or {suffixes[-1]}",
        )
    return suffix


def check_target(path: str | os.PathLike[str], suffixes: Sequence[str]) -> None:
    """Refuse a file that cannot be written, before the work for it is done.

    Raises:
        AcausalError: ``F201`` if the suffix is none of ``suffixes``, ``F202`` if its folder does
            not exist or may not be written.
    """
    check_suffix(path, suffixes)
    target = Path(path)
    if target.is_dir():
        _cannot_write(target, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))
    if not target.parent.is_dir():
        _cannot_write(target, FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)))
    if not os.access(target.parent, os.W_OK) and not target.exists():
        _cannot_write(target, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))


def write_result(
    result: Result, path: str | os.PathLike[str], patterns: Sequence[str] = ()
) -> None:
    """Write the matching variables, all if there are no patterns; expressions are computed.

    Raises:
        AcausalError: ``F201`` unknown suffix, ``F202`` cannot write, ``F203`` disk full,
            ``F205`` a library is missing, ``N901`` a pattern matches nothing.
    """
    writer = _writer(check_suffix(path))
    if any(name != "time" and not result.variables.find(name) for name in patterns):
        result, patterns = computed(result, patterns), ()
    paths = [name for name in result.find(*patterns) if name != "time"]
    with whole_file(path) as unfinished:
        writer(result, paths, unfinished)


def computed(result: Result, texts: Sequence[str]) -> Result:
    """Return a result of certain variables and expressions only, all if there are none.

    Raises:
        AcausalError: ``N901`` for an unknown name, and what expressions may raise.
    """
    if not texts:
        return result
    from acausal.results.expressions import chosen
    from acausal.results.table import TableSource

    found = [x for x in chosen(result, texts) if x.path != "time"]
    table = TableSource(
        {x.path: x.values for x in found},
        {x.path: x.unit for x in found},
        {x.path: x.description for x in found},
    )
    return replace(result, variables=table)


def read_result(path: str | os.PathLike[str]) -> Result:
    """Read a file that :func:`write_result` wrote.

    Raises:
        AcausalError: ``F201`` unknown suffix, ``F204`` cannot be read or is no result,
            ``F205`` a library is missing.
    """
    from acausal.diagnostics import AcausalError

    reader = _reader(check_suffix(path))
    try:
        return reader(Path(path))
    except AcausalError:
        raise
    except OSError as error:
        reason = error.strerror or str(error)
        fail(
            "F204",
            f"cannot read '{os.fspath(path)}': {reason}",
            help="check the name of the file, and that it is a result of acausal",
        )
    except (ValueError, KeyError, TypeError, AttributeError, RuntimeError) as error:
        fail(
            "F204",
            f"'{os.fspath(path)}' is no result file of acausal",
            notes=[str(error)[:300]],
            help="results are written by acausal simulate --output and by Result.write",
        )


def _writer(suffix: str) -> Writer:
    if suffix == ".csv":
        from acausal.results.csv_file import write_csv

        return write_csv
    if suffix == ".parquet":
        from acausal.results.parquet_file import write_parquet

        return write_parquet
    from acausal.results.netcdf_file import write_netcdf

    return write_netcdf


def _reader(suffix: str) -> Reader:
    if suffix == ".csv":
        from acausal.results.csv_file import read_csv

        return read_csv
    if suffix == ".parquet":
        from acausal.results.parquet_file import read_parquet

        return read_parquet
    from acausal.results.netcdf_file import read_netcdf

    return read_netcdf


@contextmanager
def needs(package: str, purpose: str) -> Iterator[None]:
    """Turn a failed import of an optional package into a message.

    Raises:
        AcausalError: ``F205``.
    """
    try:
        yield
    except ImportError as error:
        fail(
            "F205",
            f"{purpose} need the Python package {package}, which is not installed",
            notes=[str(error)],
            help="pip install 'acausal[files]'",
        )


@contextmanager
def whole_file(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary name in the same folder, and rename it when all is written.

    A device or pipe (``/dev/stdout``) is written directly.

    Raises:
        AcausalError: ``F203`` if the disk is full, ``F202`` if it cannot be written otherwise.
    """
    target = Path(path)
    if target.exists() and not target.is_file() and not target.is_dir():
        with told(target):
            yield target
        return
    if target.is_symlink():
        target = target.resolve()
    unfinished = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with told(target):
            if target.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(target))
            yield unfinished
            os.replace(unfinished, target)
    finally:
        unfinished.unlink(missing_ok=True)


@contextmanager
def told(target: Path) -> Iterator[None]:
    """Turn errors of the system while a file is written into messages.

    Raises:
        AcausalError: ``F202`` or ``F203``.
    """
    try:
        yield
    except OSError as error:
        _cannot_write(target, error)


def _cannot_write(target: Path, error: OSError) -> NoReturn:
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        fail(
            "F203",
            f"no space left to write '{target}'",
            notes=["nothing was written; a file of that name that was there before is unchanged"],
            help="free some space, write elsewhere, or select fewer variables with --variables",
        )
    if not target.parent.is_dir():
        help_text = f"make the folder first: mkdir -p {target.parent}"
    elif target.is_dir():
        help_text = "give the name of a file in that folder"
    else:
        help_text = "choose a folder in which you may write"
    reason = error.strerror or str(error)
    fail("F202", f"cannot write '{target}': {reason}", help=help_text)
