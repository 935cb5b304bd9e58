"""The benchmarks' own parts: tables, comparison, the C program beside the models."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from benchmarks.problems import PENDULUM, PROBLEMS, RECTIFIER, ladder  # noqa: E402
from benchmarks.processes import FailedError, Worker, last_words, run  # noqa: E402
from benchmarks.reference_program import ReferenceProgram, build  # noqa: E402
from benchmarks.solve_time import difference  # noqa: E402
from benchmarks.table import Column, Table, seconds  # noqa: E402


def test_values_above_their_bar_are_marked() -> None:
    columns = (Column("name", "name"), Column("time", "time", "s", 0.5))
    rows = [
        {"name": "fast", "time": 0.25},
        {"name": "slow", "time": 2.0},
        {"name": "own bar", "time": 2.0, "bars": {"time": 3.0}},
        {"name": "broken", "failed": "no such file"},
    ]
    table = Table("t", "Title", columns, rows)
    assert list(table.misses()) == [
        "t: slow: time 2 s, asked for 500 ms",
        "t: broken: no such file",
    ]
    text = "\n".join(table.lines())
    assert "250 ms <= 500 ms" in text
    assert "2 s ! |" in text
    assert "broken: no such file" in text


def test_not_a_number_misses_its_bar() -> None:
    table = Table("t", "", (Column("x", "x", "x", 1.3),), [{"x": float("nan")}])
    assert len(list(table.misses())) == 1


@pytest.mark.parametrize(
    ("value", "text"), [(12.345, "12.3 s"), (0.0123, "12.3 ms"), (4.5e-6, "4.5 us")]
)
def test_seconds(value: float, text: str) -> None:
    assert seconds(value) == text


def test_difference_is_relative_to_the_largest_of_its_kind() -> None:
    reference = np.zeros(8)
    reference[[0, 1, 2]] = 1.0, -2.0, 10.0
    reference[3:] = 1e-3
    values = [1.0, -2.0, 10.5, *[1e-3] * 5]
    assert difference(RECTIFIER, values, reference) == pytest.approx(0.05)


def test_models_and_variables_are_there() -> None:
    assert all(problem.file.exists() for problem in PROBLEMS)
    big = ladder(10**5)
    assert len(big.compared) < 400
    assert big.compared["section[100000].d.i"] == 3 * 10**5 - 1
    assert max(ladder(10).compared.values()) == 29


def test_a_failing_process_says_why() -> None:
    with pytest.raises(FailedError, match="ValueError: on purpose"):
        run([sys.executable, "-c", "raise ValueError('on purpose')"])
    assert run([sys.executable, "-c", "pass"]).peak > 1e6
    assert last_words("", 3) == "exit code 3"


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> ReferenceProgram:
    if not any(shutil.which(name) for name in ("gcc", "cc", "clang")):
        pytest.skip("no C compiler")
    try:
        return build(tmp_path_factory.mktemp("reference"))
    except FailedError as failure:
        if "need SUNDIALS 7" in str(failure):
            pytest.skip(str(failure))
        raise


@pytest.mark.parametrize("problem", [RECTIFIER, PENDULUM, ladder(10)], ids=lambda p: p.label)
def test_model_and_program_describe_the_same_system(
    problem: object, program: ReferenceProgram, tmp_path: Path
) -> None:
    assert isinstance(problem, type(RECTIFIER))
    end = tmp_path / "end.bin"
    figures = program.solve(problem.reference, problem.size, 1, 50, (1e-9, 1e-12), True, end)
    assert figures["steps"] > 100
    with Worker() as worker:
        worker.ask(
            action="compile",
            file=str(problem.file),
            model=problem.model,
            parameters=dict(problem.parameters),
        )
        worker.ask(action="simulate", repeats=1, points=51, tolerance=1e-9, stop=None)
        values = worker.ask(action="final", paths=list(problem.compared))["values"]
    # The double pendulum is chaotic and loses digits in ten seconds.
    allowed = 1e-3 if problem is PENDULUM else 1e-5
    assert difference(problem, values, np.fromfile(end)) < allowed


def test_command_line_writes_json(tmp_path: Path) -> None:
    file = tmp_path / "figures.json"
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", "--only", "chain", "--quick", "--json", str(file)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    (table,) = json.loads(file.read_text())["tables"]
    assert [row["links"] for row in table["rows"]] == [2, 10]
    assert all(row["position"] < 1e-6 for row in table["rows"])
