"""The command line with the real compiler, from a file to a file."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from acausal.cli.main import execute
from acausal.results import Ending, read_result

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")

DECAY = """model Decay "exponential decay"
  parameter Real tau(unit = "s") = 2[s] "time constant";
  Real x(start = 1, fixed = true) "what decays";
equation
  tau*der(x) = -x;
  annotation(experiment(StopTime = 4));
end Decay;
"""

BLOW_UP = """model BlowUp "grows beyond all bounds at t = 1"
  Real x(start = 1, fixed = true);
equation
  der(x) = x^2;
end BlowUp;
"""

FAST = """model Fast "far more oscillations than anybody waits for"
  Real x(start = 1, fixed = true);
  Real y(start = 0, fixed = true);
equation
  der(x) = 1e6*y;
  der(y) = -1e6*x;
end Fast;
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("decay.acm").write_text(DECAY, encoding="utf-8")
    Path("blowup.acm").write_text(BLOW_UP, encoding="utf-8")


def test_from_text_to_csv():
    assert execute(["simulate", "decay.acm", "-o", "run.csv", "--interval", "1"]) == 0
    result = read_result("run.csv")
    np.testing.assert_allclose(result.times, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(result["x"].values, np.exp(-result.times / 2), rtol=1e-4)
    assert result["x"].description == "what decays"
    assert result.model_name == "Decay"


def test_parameter_with_unit_and_interval():
    words = "simulate decay.acm -p tau=100[ms] --stop 300[ms] --points 4 --output run.nc"
    assert execute(words.split()) == 0
    result = read_result("run.nc")
    np.testing.assert_allclose(result.times, [0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(result["x"].values, np.exp(-result.times / 0.1), rtol=1e-4)


def test_a_failing_run_keeps_what_there_is(capsys):
    assert execute(["simulate", "blowup.acm", "--stop", "2", "-o", "run.csv"]) == 3
    err = capsys.readouterr().err
    assert re.search(r"error\[R\d{3}\]", err)
    result = read_result("run.csv")
    assert result.ending is Ending.FAILED
    assert 0.9 < result.times[-1] <= 1.01
    assert result["x"](0.5) == pytest.approx(2.0, rel=1e-3)


def test_mistakes_are_told_with_their_place(capsys):
    Path("decay.acm").write_text(DECAY.replace("2[s] ", "2[sx] "), encoding="utf-8")
    assert execute(["simulate", "decay.acm", "--json-errors"]) == 1
    (found,) = json.loads(capsys.readouterr().err)["diagnostics"]
    assert found["code"] == "U104"
    assert (found["span"]["source"], found["span"]["line"]) == ("decay.acm", 2)


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("simulate nothing.acm", "F101"),
        ("simulate decay.acm Growth", "F105"),
        ("simulate decay.acm -p T=3", "N119"),
        ("simulate decay.acm -v y", "N901"),
        ("simulate decay.acm --stop -1", "R010"),
    ],
)
def test_coded_messages(capsys, words, code):
    assert execute(words.split()) == 1
    assert f"error[{code}]" in capsys.readouterr().err


def test_check_counts(capsys):
    assert execute(["check", "decay.acm"]) == 0
    assert "1 equation" in capsys.readouterr().out


@pytest.mark.parametrize("stage", ["flatten", "structure", "all"])
def test_inspect(capsys, stage):
    assert execute(["inspect", "decay.acm", "--stage", stage]) == 0
    assert capsys.readouterr().out.strip()


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="needs POSIX signals")
def test_interrupt_keeps_what_was_computed():
    Path("fast.acm").write_text(FAST, encoding="utf-8")
    assert execute(["check", "fast.acm"]) == 0  # so that the next run starts at once
    command = [sys.executable, "-m", "acausal", "simulate", "fast.acm", "-o", "run.csv"]
    command += ["--stop", "1000", "--points", "100000"]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    time.sleep(2.0)
    run.send_signal(signal.SIGINT)
    _, err = run.communicate(timeout=60)
    assert run.returncode == 130, err
    assert "interrupted" in err
    assert "Traceback" not in err
    result = read_result("run.csv")
    assert result.ending is Ending.INTERRUPTED
    assert 0 < result.times[-1] < 1000
    assert max(abs(result["x"].values)) <= 1.1


def test_the_readme_example_is_the_example_file(tmp_path):
    model, *_ = re.findall(r"```modelica\n(.*?)```", README, re.DOTALL)
    Path("rlc.acm").write_text(model, encoding="utf-8")
    assert execute(["simulate", "rlc.acm", "-o", "readme.csv"]) == 0
    assert execute(["simulate", str(ROOT / "examples/rlc.acm"), "-o", "example.csv"]) == 0
    a, b = read_result("readme.csv"), read_result("example.csv")
    np.testing.assert_array_equal(a["c.v"].values, b["c.v"].values)
    # Far below resonance the capacitor takes the source's voltage.
    assert max(a["c.v"]) == pytest.approx(10.0, rel=1e-2)
    assert a["c.v"](0.045) == pytest.approx(10 * math.sin(2 * math.pi * 50 * 0.045), abs=0.4)


def test_the_readme_python_code_runs(monkeypatch):
    import acausal

    (program,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    model, *_ = re.findall(r"```modelica\n(.*?)```", README, re.DOTALL)
    Path("rlc.acm").write_text(model, encoding="utf-8")
    exec(program, {})
    assert Path("rlc.png").stat().st_size > 1000
    assert acausal.compile_file("rlc.acm").name == "RLC"


def test_the_readme_ball_comes_to_rest():
    from acausal import compile_text

    _, ball = re.findall(r"```modelica\n(.*?)```", README, re.DOTALL)
    result = compile_text(ball).simulate(stop_time=10)
    assert result["v"].values[-1] == 0
    assert abs(result["h"].values[-1]) < 1e-9


def test_the_readme_commands_are_the_ones_that_ci_runs():
    shell = [line for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
             for line in block.splitlines() if "bootstrap" in line]  # fmt: skip
    assert len(shell) == 2
    ci = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert shell[1] in ci
    assert os.access(ROOT / ".ci/bootstrap", os.X_OK)
    example = re.findall(r"examples/\S+", shell[0])
    assert [(ROOT / name).is_file() for name in example] == [True]
    images = re.findall(r"docs/images/\S+?\.png", README)
    assert [name for name in images if not (ROOT / name).is_file()] == []
