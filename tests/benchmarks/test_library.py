"""The benchmark of the library measures what it says."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from acausal.modeling.load import load_file  # noqa: E402
from acausal.reference.examples import used_classes  # noqa: E402
from benchmarks.library import package_names  # noqa: E402
from benchmarks.processes import MODELS, Worker  # noqa: E402


def test_the_model_has_components_of_fifty_classes() -> None:
    model = load_file(MODELS / "fifty_classes.acm")[0]["FiftyClasses"]
    used = {c.full_name for c in used_classes(model)}
    assert len(used) >= 50
    assert len({name.rpartition(".")[0] for name in used}) == 6


def test_all_packages_are_measured() -> None:
    names = package_names()
    assert {"electrical", "electrical.digital", "constants", "mechanical.rotational"} <= set(names)
    assert len(names) == len(set(names))


def test_a_worker_reads_a_package() -> None:
    with Worker() as worker:
        answer = worker.ask(action="parse", package="thermal")
    assert answer["files"] >= 4
    assert answer["classes"] >= 20
    assert answer["parse"] > 0
