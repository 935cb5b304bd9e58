"""Writing a result while the run goes on, so that memory stays flat.

The file grows under its own name, chunk by chunk, and is closed properly after an interruption or a
failure, too. Against a full disk some space is kept free beside it: when the disk is full, that
space is given back, so that the chunk which is being written and the end of the file still fit.
"""

from __future__ import annotations

import contextlib
import errno
import io
import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from acausal.diagnostics import AcausalError, fail
from acausal.diagnostics.suggest import nearest
from acausal.results.files import check_suffix, check_target, told
from acausal.results.patterns import matching
from acausal.results.result import Ending, Result

Array = NDArray[np.float64]

#: What can be written while a run goes on.
SUFFIXES = (".csv", ".nc", ".h5", ".hdf5", ".parquet")
#: Numbers in a chunk.
CHUNK = 1_000_000
#: Space for the end of a file: names, units and parameters are in it, bytes.
ROOM_FOR_END = 4_000_000


class ReservedFile(io.RawIOBase):
    """A file beside which space is kept free for its end.

    Attributes:
        full: Whether the disk was full, so that the space kept free is being used.
    """

    def __init__(self, path: Path, reserve: int) -> None:
        """Open the file for writing, and take the space.

        Raises:
            OSError: If it cannot be opened, or there is no space.
        """
        super().__init__()
        self.full = False
        self._number = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        self._reserve: Path | None = path.with_name(f".{path.name}.{os.getpid()}.reserve")
        try:
            _take_space(self._reserve, reserve)
        except BaseException:
            self.close()
            raise

    def readable(self) -> bool:
        """Return True."""
        return True

    def writable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, buffer: Any) -> int:
        """Read into a buffer; return how many bytes."""
        view = memoryview(buffer).cast("B")
        data = os.read(self._number, len(view))
        view[: len(data)] = data
        return len(data)

    def write(self, data: Any) -> int:
        """Write all bytes, with the help of the reserve if it must be."""
        view = memoryview(data).cast("B")
        done = 0
        while done < len(view):
            try:
                done += os.write(self._number, view[done:])
            except OSError as error:
                if error.errno not in (errno.ENOSPC, errno.EDQUOT) or self._reserve is None:
                    raise
                self.full = True
                self._give_back()
        return done

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a position; return it."""
        return os.lseek(self._number, offset, whence)

    def tell(self) -> int:
        """Return the position."""
        return os.lseek(self._number, 0, os.SEEK_CUR)

    def truncate(self, size: int | None = None) -> int:
        """Set the length; return it."""
        length = self.tell() if size is None else size
        os.ftruncate(self._number, length)
        return length

    def _give_back(self) -> None:
        if self._reserve is not None:
            self._reserve.unlink(missing_ok=True)
            self._reserve = None

    def close(self) -> None:
        """Close the file and give the space back."""
        if not self.closed:
            self._give_back()
            super().close()
            os.close(self._number)


def _take_space(path: Path, size: int) -> None:
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
    try:
        try:
            os.posix_fallocate(number, 0, size)
        except OSError as error:
            if error.errno in (errno.ENOSPC, errno.EDQUOT):
                raise
            while size > 0:  # a file system that cannot promise space
                size -= os.write(number, bytes(min(size, 1 << 20)))
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    finally:
        os.close(number)


class Writer(Protocol):
    """One file format, written in chunks."""

    def add(self, times: Array, values: Array) -> None:
        """Append rows, ``values`` of shape ``(len(times), variables)``."""

    def finish(self, result: Result) -> None:
        """Write what is known at the end, and complete the file."""


class Stream:
    """A result file that grows.

    Attributes:
        path: The file.
        paths: The variables in it.
        rows: Rows written so far.
        reached: Time of the last one, seconds.
        full: Whether it ended because the disk was full.
    """

    def __init__(self, path: str | os.PathLike[str], head: Result, paths: Sequence[str]) -> None:
        """Open the file and write what is known before the run.

        Args:
            path: The file; its suffix chooses the format.
            head: A result without points: names, units, parameters.
            paths: The variables to write.

        Raises:
            AcausalError: ``F201``, ``F202``, ``F203`` or ``F205``.
        """
        check_target(path, SUFFIXES)
        self.path, self.paths = Path(path), list(paths)
        self.rows, self.reached, self.full = 0, float("nan"), False
        self._head = replace(head, ending=Ending.INTERRUPTED)
        self._file: ReservedFile | None = None
        reserve = 3 * 8 * CHUNK + ROOM_FOR_END + 400 * len(self.paths)
        with told(self.path):
            self._file = ReservedFile(self.path, reserve)
            try:
                self._writer = _writer(self.path, self._file, self._head, self.paths)
            except BaseException:
                self._file.close()
                self.path.unlink(missing_ok=True)
                raise

    def add(self, times: Array, values: Array) -> None:
        """Append rows.

        Raises:
            AcausalError: ``F207`` if the disk is full; the file is complete then, and closed.
        """
        if self._file is None or not len(times):
            return
        try:
            with told(self.path):
                self._writer.add(times, values)
        except AcausalError:
            self._drop()
            raise
        self.rows += len(times)
        self.reached = float(times[-1])
        if self._file.full:
            self.full = True
            self.finish(replace(self._head, ending=Ending.FAILED))
            fail("F207", f"no space left to go on writing '{self.path}'",
                 notes=[f"{self.rows} points up to {self.reached:g} s are in the file, "
                        "which is complete"],
                 help="free some space, write elsewhere, or choose fewer variables "
                 "or points")  # fmt: skip

    def finish(self, result: Result | None = None) -> None:
        """Complete the file with what is known at the end; nothing if that was done already.

        Args:
            result: The result; None if the run was broken off.

        Raises:
            AcausalError: ``F202`` or ``F203`` if that cannot be written.
        """
        if self._file is None:
            return
        try:
            with told(self.path):
                self._writer.finish(self._head if result is None else result)
        finally:
            self._drop()

    def _drop(self) -> None:
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()
            self._file = None


class StreamedSource:
    """A :class:`~acausal.results.result.VariableSource` that reads a file when asked.

    Args:
        stream: What was written.
        labels: Units, descriptions and suggestions.
    """

    def __init__(self, stream: Stream, labels: Any) -> None:
        self._file, self._paths, self._labels = stream.path, stream.paths, labels
        self._places = dict.fromkeys(stream.paths)

    def paths(self) -> Sequence[str]:
        """Return the paths of what was written."""
        return self._paths

    def find(self, pattern: str) -> list[str]:
        """Return the paths that match."""
        return [pattern] if pattern in self._places else matching(pattern, self._paths)

    def values(self, path: str) -> Array:
        """Return a column, read from the file.

        Raises:
            KeyError: If there is none.
        """
        return self.many([path])[:, 0]

    def many(self, paths: Sequence[str]) -> Array:
        """Return several columns, read from the file.

        Raises:
            KeyError: If there is no such column.
        """
        for path in paths:
            if path not in self._places:
                raise KeyError(path)
        return read_columns(self._file, paths)

    def unit(self, path: str) -> str:
        """Return the unit text."""
        return str(self._labels.unit(path))

    def description(self, path: str) -> str:
        """Return the description string."""
        return str(self._labels.description(path))

    def suggestions(self, path: str) -> list[str]:
        """Return the nearest paths."""
        return nearest(path, self._paths)


def read_columns(file: Path, paths: Sequence[str]) -> Array:
    """Return columns of a result file, ``time`` among them, shape ``(nt, len(paths))``."""
    suffix = check_suffix(file)
    if suffix == ".csv":
        from acausal.results.csv_file import columns
    elif suffix == ".parquet":
        from acausal.results.parquet_file import columns
    else:
        from acausal.results.netcdf_file import columns
    return columns(file, paths)


def _writer(path: Path, file: ReservedFile, head: Result, paths: Sequence[str]) -> Writer:
    suffix = check_suffix(path)
    if suffix == ".csv":
        from acausal.results.csv_file import CSVStream

        return CSVStream(file, head, paths)
    if suffix == ".parquet":
        from acausal.results.parquet_file import ParquetStream

        return ParquetStream(file, head, paths)
    from acausal.results.netcdf_file import NetCDFStream

    return NetCDFStream(file, head, paths)
