"""Where the points of a sweep are run: here, in processes of this machine, or on a Dask cluster.

A worker gets the job once and chunks of points after that. Kernels come from the cache on its
disk, or are compiled there once.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from typing import Any

from acausal.diagnostics import fail
from acausal.runs.job import Job, Outcome
from acausal.runs.points import Point

Numbered = tuple[int, Point]

#: Chunks for each worker: enough to share the load, few enough to cost nothing.
CHUNKS_PER_WORKER = 8
#: Points of a chunk at most, so that progress is seen and stores grow.
LARGEST_CHUNK = 50

_job: Job | None = None


def run_here(job: Job, points: Sequence[Numbered]) -> Iterator[list[Outcome]]:
    """Run the points one after the other in this process."""
    for number, point in points:
        yield [job.run(number, point)]


def run_in_processes(job: Job, points: Sequence[Numbered], workers: int) -> Iterator[list[Outcome]]:
    """Run the points in processes of this machine; outcomes come in any order.

    Args:
        job: What to do.
        points: The points.
        workers: Number of processes.
    """
    # A fork has the job and its loaded kernels at once; elsewhere they are sent.
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if "fork" in methods else "spawn")
    pool = ProcessPoolExecutor(workers, context, _begin, (job,))
    try:
        waiting: set[Future[list[Outcome]]] = {
            pool.submit(_run, chunk) for chunk in chunks(points, workers)
        }
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=lambda f: f.result()[0].number):
                yield future.result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def run_on_cluster(job: Job, points: Sequence[Numbered], address: str) -> Iterator[list[Outcome]]:
    """Run the points on the workers of a Dask scheduler; outcomes come in any order.

    Args:
        job: What to do.
        points: The points.
        address: Of the scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        AcausalError: ``F142`` if Dask is not installed or the scheduler does not answer.
    """
    try:
        import distributed as dask
    except ImportError:
        fail("F142", "Dask is not installed", help="pip install 'acausal[dask]'")
    cluster: Any = dask
    try:
        client: Any = cluster.Client(address, timeout=10)
    except (OSError, ValueError) as error:
        fail("F142", f"no Dask scheduler answers at {address}", notes=[str(error)],
             help="start one with `dask scheduler`, and workers with `dask worker`")  # fmt: skip
    with client:
        workers = max(len(client.scheduler_info()["workers"]), 1)
        shared = client.scatter(job, broadcast=True)
        futures = [
            client.submit(_run_shared, shared, chunk, pure=False)
            for chunk in chunks(points, workers)
        ]
        try:
            for future in cluster.as_completed(futures):
                yield future.result()
        finally:
            client.cancel([f for f in futures if not f.done()])


def chunks(points: Sequence[Numbered], workers: int) -> list[list[Numbered]]:
    """Divide points between workers."""
    size = max(1, min(LARGEST_CHUNK, -(-len(points) // (workers * CHUNKS_PER_WORKER))))
    return [list(points[k : k + size]) for k in range(0, len(points), size)]


def processors() -> int:
    """Return the number of processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin(job: Job) -> None:
    global _job
    _job = job


def _run(points: Sequence[Numbered]) -> list[Outcome]:
    assert _job is not None
    return _job.run_chunk(points)


def _run_shared(job: Job, points: Sequence[Numbered]) -> list[Outcome]:
    return job.run_chunk(points)
