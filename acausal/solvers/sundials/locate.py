"""Finds SUNDIALS' shared libraries without importing the packages that carry them.

Sources, best first:

1. the wheel ``pybammsolvers`` (IDAS with the sparse solver KLU);
2. the wheel ``scikit-sundae`` (IDA with SuperLU_MT);
3. the system's libraries, e.g. Debian's, which are built without optimisation.

The environment variable ``ACAUSAL_SUNDIALS`` chooses one of them (``pybammsolvers``,
``scikit-sundae``, ``system``) or names a folder.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import os
import re
import sys
import sysconfig
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from acausal.diagnostics import fail

#: Environment variable that chooses the source.
VARIABLE = "ACAUSAL_SUNDIALS"
#: Oldest and first untested major version whose C interface we speak.
OLDEST, TOO_NEW = (6, 0, 0), (8, 0, 0)

_FILE = re.compile(
    r"^(?:lib)?sundials_(?P<part>[a-z]+)(?:-[0-9a-f]{6,})?(?P<end>\.so|\.dylib|\.dll|(?:\.\d+)+\.dylib)"
    r"(?P<version>[.\d]*)$"
)
_NEEDED = ("nvecserial", "sunmatrixdense", "sunmatrixsparse", "sunlinsoldense")


@dataclass(frozen=True)
class Location:
    """A folder with SUNDIALS' shared libraries.

    Attributes:
        source: ``pybammsolvers``, ``scikit-sundae``, ``system`` or the folder's path.
        folder: Where the libraries are.
        files: Library file by component, e.g. ``idas``, ``nvecserial``.
    """

    source: str
    folder: Path
    files: Mapping[str, Path]

    @property
    def integrator(self) -> str | None:
        """``idas`` or ``ida``, None if there is neither."""
        return next((name for name in ("idas", "ida") if name in self.files), None)

    @property
    def sparse(self) -> str | None:
        """``klu`` or ``superlumt``, None if there is no sparse direct solver."""
        return next((s for s in ("klu", "superlumt") if f"sunlinsol{s}" in self.files), None)

    @property
    def complete(self) -> bool:
        """Everything that an integration needs is there."""
        return (
            self.integrator is not None
            and self.sparse is not None
            and all(part in self.files for part in _NEEDED)
        )


class Sundials:
    """Loaded libraries of one location.

    Attributes:
        location: Where they come from.
        version: Version number, three integers.
        index_bytes: Width of ``sunindextype``, 4 or 8.
    """

    def __init__(self, location: Location) -> None:
        """Load the libraries and ask them for their version.

        Raises:
            AcausalError: R101 if a library cannot be loaded or is of a version that we do not
                speak.
        """
        self.location = location
        self._libraries: dict[str, ctypes.CDLL] = {}
        if sys.platform == "win32":
            self._folder = os.add_dll_directory(str(location.folder))
        for part in ("core", "generic", location.integrator, *_NEEDED):
            if part is not None and part in location.files:
                self._load(part)
        self.version = self._version()
        if not OLDEST <= self.version < TOO_NEW:
            fail(
                "R101",
                f"SUNDIALS {self.version_text} in {location.folder} is not supported",
                help="install a version from 6.0 to 7.x: pip install pybammsolvers",
            )
        self.index_bytes = 0  # known as soon as the binding has asked

    @property
    def version_text(self) -> str:
        """Version as text, e.g. ``7.6.0``."""
        return ".".join(map(str, self.version))

    def _load(self, part: str) -> ctypes.CDLL:
        path = self.location.files[part]
        try:
            # Symbols stay local: a second SUNDIALS in the process (scikits-odes) must not
            # bind to these, nor these to it.
            library = ctypes.CDLL(str(path))
        except OSError as error:
            fail(
                "R101",
                f"cannot load SUNDIALS' library {path.name}",
                notes=(str(error),),
                help=f"reinstall {self.location.source}, or set {VARIABLE} to another source",
            )
        self._libraries[part] = library
        return library

    def _version(self) -> tuple[int, int, int]:
        numbers = [ctypes.c_int() for _ in range(3)]
        label = ctypes.create_string_buffer(32)
        get = self.function("SUNDIALSGetVersionNumber")
        get(*(ctypes.byref(number) for number in numbers), label, ctypes.c_int(len(label)))
        major, minor, patch = (number.value for number in numbers)
        return major, minor, patch

    def function(self, name: str, part: str | None = None) -> ctypes._NamedFuncPointer:
        """Return the C function ``name``, loading the library of component ``part`` first.

        Raises:
            AttributeError: No loaded library has it.
        """
        if part is not None and part not in self._libraries:
            self._load(part)
        # The integrator's library first: up to 6.x every library has its own copy of the
        # generic functions, and any of them would do.
        for library in self._libraries.values():
            try:
                return library[name]
            except AttributeError:
                continue
        raise AttributeError(name)

    def describe(self) -> str:
        """Return one line for people: version, integrator, sparse solver, source."""
        solver = {"klu": "KLU", "superlumt": "SuperLU_MT"}[str(self.location.sparse)]
        width = f", {8 * self.index_bytes}-bit indices" if self.index_bytes else ""
        name = str(self.location.integrator).upper()
        where = self.location.source
        return f"SUNDIALS {self.version_text} ({name}, {solver}{width}) from {where}"


def _files(folder: Path) -> dict[str, Path]:
    """Return library files by component; of several versions the shortest name."""
    found: dict[str, Path] = {}
    try:
        names = sorted(entry.name for entry in os.scandir(folder) if "sundials_" in entry.name)
    except OSError:
        return {}
    for name in sorted(names, key=len):
        match = _FILE.match(name)
        if match is not None:
            found.setdefault(match["part"], folder / name)
    return found


def _wheel_folders(package: str, distribution: str) -> Iterator[Path]:
    """Yield where auditwheel, delocate and delvewheel put a wheel's libraries."""
    try:
        spec = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return
    if spec is None or spec.origin is None:
        return
    inside = Path(spec.origin).parent
    yield inside.parent / f"{distribution}.libs"
    yield inside / ".dylibs"


def _system_folders() -> Iterator[Path]:
    for folder in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep):
        if folder:
            yield Path(folder)
    yield Path("/usr/local/lib")
    multiarch = sysconfig.get_config_var("MULTIARCH")
    if multiarch:
        yield Path("/usr/lib") / str(multiarch)
    yield from map(Path, ("/usr/lib64", "/usr/lib", "/opt/homebrew/lib"))
    yield Path(sys.prefix) / "lib"


def locations() -> Iterator[Location]:
    """Yield every complete SUNDIALS on this machine, best first."""
    for source, package, distribution in (
        ("pybammsolvers", "pybammsolvers", "pybammsolvers"),
        ("scikit-sundae", "sksundae", "scikit_sundae"),
    ):
        for folder in _wheel_folders(package, distribution):
            location = Location(source, folder, _files(folder))
            if location.complete:
                yield location
                break
    for folder in _system_folders():
        location = Location("system", folder, _files(folder))
        if location.complete:
            yield location
            break


def choose(wanted: str | None = None) -> Location:
    """Return the best location, or the one that is asked for.

    Args:
        wanted: Source name or folder; None takes ``ACAUSAL_SUNDIALS``, else the best.

    Raises:
        AcausalError: R101 if there is none.
    """
    wanted = wanted or os.environ.get(VARIABLE) or None
    found = None
    if wanted is not None and os.sep in wanted:
        location = Location(wanted, Path(wanted), _files(Path(wanted)))
        found = location if location.complete else None
    else:
        found = next((x for x in locations() if wanted in (None, x.source)), None)
    if found is None:
        fail(
            "R101",
            "SUNDIALS was not found" + (f" as {wanted!r}" if wanted else ""),
            notes=("the solver ida needs SUNDIALS' libraries",),
            help="pip install pybammsolvers, or choose the solver radau",
        )
    return found


@functools.cache
def load(wanted: str | None = None) -> Sundials:
    """Load SUNDIALS once per process.

    Args:
        wanted: As for :func:`choose`.

    Raises:
        AcausalError: R101 if it is not there, cannot be loaded, or has a wrong version.
    """
    location = choose(wanted)
    if location.source == "system":
        warnings.warn(
            "SUNDIALS comes from the system, which may be built without optimisation; "
            "pip install pybammsolvers gives a faster one",
            stacklevel=2,
        )
    return Sundials(location)


def describe() -> str:
    """Return one line about the SUNDIALS in use, for ``acausal --version``."""
    from acausal.diagnostics import AcausalError
    from acausal.solvers.sundials.binding import bind

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return bind().sundials.describe()
    except AcausalError as error:
        return f"no SUNDIALS: {error.diagnostics[0].message}"
