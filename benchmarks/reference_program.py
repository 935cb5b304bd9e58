"""Builds and runs the hand-written C programs against the SUNDIALS that acausal uses."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.processes import FailedError

SOURCES = Path(__file__).resolve().parent / "reference"
PARTS = ("core", "nvecserial", "sunmatrixsparse", "sunlinsolklu")
SMOOTH = ("main.c", "ladder.c", "rectifier.c", "pendulum.c")
EVENTS = ("events_main.c", "events_mechanics.c", "events_circuits.c", "events_array.c")


@dataclass(frozen=True)
class ReferenceProgram:
    """The compiled program.

    Attributes:
        path: The executable.
        description: Which SUNDIALS it is linked with, and by which compiler.
    """

    path: Path
    description: str

    def solve(
        self,
        problem: str,
        size: int,
        repeats: int,
        points: int,
        tolerance: tuple[float, float],
        suppress: bool,
        end_file: Path | None = None,
    ) -> dict[str, Any]:
        """Integrate a problem some times; return the figures of the fastest.

        Raises:
            FailedError: If IDA gives up.
        """
        return self._best(
            problem, size, repeats, points, *tolerance, int(suppress), end_file or "-"
        )

    def solve_events(
        self,
        problem: str,
        repeats: int,
        stop: float,
        tolerance: tuple[float, float],
        size: int = 0,
        relations: bool = True,
        end_file: Path | None = None,
    ) -> dict[str, Any]:
        """Run a problem of the program with events some times; return the figures of the fastest.

        Raises:
            FailedError: If IDA gives up.
        """
        return self._best(
            problem, size, int(relations), repeats, *tolerance, repr(stop), end_file or "-"
        )

    def _best(self, *arguments: Any) -> dict[str, Any]:
        done = subprocess.run(
            [str(self.path), *map(str, arguments)], capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise FailedError(f"reference program: {done.stderr.strip()}")
        figures = [json.loads(line) for line in done.stdout.splitlines()]
        best: dict[str, Any] = min(figures, key=lambda f: f["cpu"])
        return best


def build(folder: Path, sources: tuple[str, ...] = SMOOTH) -> ReferenceProgram:
    """Compile a program.

    Args:
        folder: Where the executable goes.
        sources: Its files.

    Raises:
        FailedError: There is no compiler, no SUNDIALS 7 with KLU, or the compiler refuses.
    """
    from acausal.solvers.sundials.binding import bind

    compiler = shutil.which("gcc") or shutil.which("cc") or shutil.which("clang")
    if compiler is None:
        raise FailedError("no C compiler (gcc, cc or clang) was found")
    binding = bind()
    location, version = binding.sundials.location, binding.sundials.version
    if version < (7, 0, 0) or location.sparse != "klu":
        raise FailedError(
            f"the reference programs need SUNDIALS 7 with KLU (pip install pybammsolvers), "
            f"not {binding.sundials.describe()}"
        )
    files = location.files
    libraries = [files[p] for p in (location.integrator, *PARTS) if p is not None and p in files]
    program = folder / sources[0].removesuffix(".c")
    command = [
        compiler, "-O2", f"-DINDEX_BITS={8 * binding.index_bytes}", "-o", str(program),
        *(str(SOURCES / name) for name in sources),
        *map(str, libraries), f"-Wl,-rpath,{location.folder}", "-lm",
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise FailedError(f"the C compiler refuses: {done.stderr.strip()[:500]}")
    name = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False)
    first = name.stdout.splitlines()[0] if name.stdout else compiler
    return ReferenceProgram(program, f"{binding.sundials.describe()}; {first}, -O2")
