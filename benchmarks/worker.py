"""A process that compiles and simulates on request and says how long it took.

Requests and answers are lines of JSON on the standard streams. Each benchmark uses a process of
its own, so that peak memory and first-time costs are its own.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import time
from pathlib import Path
from typing import Any

BEGIN = time.perf_counter()


class Session:
    """What one process holds: the compiled model and its last result."""

    def __init__(self) -> None:
        self.compiled: Any = None
        self.result: Any = None

    def compile(self, file: str, model: str, parameters: dict[str, Any]) -> dict[str, Any]:
        """Compile a model; the first time includes the imports that it needs."""
        begin = time.perf_counter()
        from acausal import compile_file

        imported = time.perf_counter()
        self.compiled = self.result = None
        self.compiled = compile_file(Path(file), model=model, parameters=parameters)
        end = time.perf_counter()
        return {
            "import": imported - begin,
            "compile": end - imported,
            "stages": {k: float(v) for k, v in self.compiled.timings.items()},
            "peak": peak(),
        }

    def parse(self, package: str) -> dict[str, Any]:
        """Read all files of a library package, not those of the packages inside of it."""
        from acausal.modeling.library import FolderPackage, standard_library
        from acausal.modeling.load import library_class
        from acausal.syntax.cache import parse_cached  # noqa: F401 - imports are not timed

        begin = time.perf_counter()
        found = library_class(package, standard_library())
        assert found is not None
        classes = getattr(found, "classes", {})
        return {
            "parse": time.perf_counter() - begin,
            "classes": len(classes),
            "files": len(found.files) if isinstance(found, FolderPackage) else 1,
        }

    def simulate(
        self, repeats: int, points: int, tolerance: float, stop: float | None
    ) -> dict[str, Any]:
        """Simulate some times; the answer tells about the run with the shortest solve time."""
        best: dict[str, Any] = {}
        for _ in range(repeats):
            self.result = None
            begin, cpu = time.perf_counter(), time.process_time()
            self.result = self.compiled.simulate(
                stop_time=stop, tolerance=tolerance, solver="ida", points=points
            )
            answer: dict[str, Any] = dict(self.result.statistics)
            answer |= {
                "wall": time.perf_counter() - begin,
                "cpu": time.process_time() - cpu,
                "end": float(self.result.times[-1]),
                "ending": self.result.ending.value,
                "events": len(self.result.events),
                "peak": peak(),
            }
            if not best or answer["solve_cpu_time"] < best["solve_cpu_time"]:
                best = answer
        if best["ending"] != "complete":
            raise RuntimeError(f"the run ended early, at {best['end']:g} s")
        return best

    def final(self, paths: list[str]) -> dict[str, Any]:
        """Return the last values of variables."""
        return {"values": [float(self.result[path].values[-1]) for path in paths]}

    def chain_errors(self, links: int, length: float) -> dict[str, Any]:
        """Return the worst errors of constraints and energy of a pendulum chain."""
        import numpy as np

        result = self.result

        def of(link: int, name: str) -> Any:
            return result[f"link[{link}].{name}"].values

        position = velocity = 0.0
        x = y = vx = vy = np.zeros(len(result.times))
        kinetic = np.zeros(len(result.times))
        for k in range(1, links + 1):
            nx, ny, nvx, nvy = (of(k, name) for name in ("tip.x", "tip.y", "vx", "vy"))
            dx, dy = nx - x, ny - y
            position = max(position, float(np.abs(np.hypot(dx, dy) - length).max()))
            along = (dx * (nvx - vx) + dy * (nvy - vy)) / length
            velocity = max(velocity, float(np.abs(along).max()))
            kinetic += of(k, "E_kin")
            x, y, vx, vy = nx, ny, nvx, nvy
        energy = result["energy"].values
        return {
            "position": position,
            "velocity": velocity,
            "energy": float(np.abs(energy - energy[0]).max()),
            "kinetic": float(kinetic.max()),
        }


def peak() -> int:
    """Return this process's largest resident memory so far, bytes."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def main() -> None:
    """Answer requests until the standard input ends."""
    session = Session()
    # Whatever a model prints must not get between the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        request = json.loads(line)
        action = request.pop("action")
        try:
            answer = getattr(session, action)(**request)
        except Exception as error:  # noqa: BLE001 - reported to the other side
            answer = {"error": f"{type(error).__name__}: {error}"[:300]}
            if os.environ.get("BENCHMARK_TRACEBACK"):
                import traceback

                traceback.print_exc()
        answers.write(json.dumps(answer, default=float) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
