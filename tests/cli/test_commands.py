"""The command line: options, exit codes, messages. The compiler is a stand-in here."""

from __future__ import annotations

import json
import subprocess
import sys
import types
from pathlib import Path

import numpy as np
import pytest

import acausal
from acausal.cli.main import COMMANDS, execute
from acausal.cli.options import read_parameters
from acausal.diagnostics import AcausalError, Diagnostic, Severity, Span
from acausal.results import Ending, Result, read_result
from acausal.results.table import TableSource


class Compiled:
    """Remembers what it was asked for and returns a sine."""

    def __init__(self, calls: list[dict], ending: Ending) -> None:
        self.calls = calls
        self.ending = ending
        self.timings = {"parse": 0.001, "flatten": 0.002}
        self.warnings: tuple[Diagnostic, ...] = ()
        self.system = types.SimpleNamespace(variables=types.SimpleNamespace(count=2))

    def simulate(self, **asked) -> Result:
        self.calls.append(asked)
        asked["progress"](0.5, 1.0)
        times = np.linspace(0.0, 1.0, asked["points"] or 5)
        columns = {"c.v": np.sin(times), "l.i": np.cos(times)}
        source = TableSource(columns, {"c.v": "V", "l.i": "A"})
        failed = Diagnostic("R101", "the step became too small")
        return Result(
            "RLC",
            "circuit",
            times,
            source,
            states=("c.v",),
            ending=self.ending,
            diagnostics=(failed,) if self.ending is Ending.FAILED else (),
        )


class Compiler(types.ModuleType):
    """A stand-in for ``acausal.compiler``."""

    def __init__(self) -> None:
        super().__init__("acausal.compiler")
        self.calls: list[dict] = []
        self.ending = Ending.COMPLETE
        self.error: BaseException | None = None

    def compile_file(self, path, model=None, parameters=None) -> Compiled:
        self.calls.append({"path": path, "model": model, "parameters": parameters})
        if self.error is not None:
            raise self.error
        compiled = Compiled(self.calls, self.ending)
        if parameters and "huge" in parameters:
            compiled.system.variables.count = 10**6
        return compiled

    def check_file(self, path, model=None) -> str:
        if self.error is not None:
            raise self.error
        return f"{path}: 5 equations, 5 unknowns"

    def inspect_file(self, path, model=None, stage="all", latex=False, parameters=None) -> str:
        return f"{path} {model} {stage} {latex}"


@pytest.fixture
def compiler(monkeypatch, tmp_path):
    stub = Compiler()
    monkeypatch.setitem(sys.modules, "acausal.compiler", stub)
    monkeypatch.setattr(acausal, "compiler", stub, raising=False)
    monkeypatch.chdir(tmp_path)
    return stub


def test_simulate_passes_everything_on(compiler, capsys):
    words = "simulate rlc.acm RLC -p r.R=1[kOhm] -p a[1,2].k=3 --start 1 --stop 2[ms]"
    words += " --tolerance 1e-8 --solver radau --points 7 --output run.csv"
    assert execute([*words.split(), "--variables", "c.*,l.i"]) == 0
    assert compiler.calls[0] == {
        "path": Path("rlc.acm"),
        "model": "RLC",
        "parameters": {"r.R": "1[kOhm]", "a[1,2].k": 3.0},
    }
    asked = compiler.calls[1]
    asked.pop("progress")
    assert asked == {
        "start_time": 1.0,
        "stop_time": 0.002,
        "tolerance": 1e-8,
        "solver": "radau",
        "points": 7,
        "interval": None,
        "variables": ("c.*", "l.i"),
    }
    assert len(read_result("run.csv").times) == 7
    assert "7 points" in capsys.readouterr().err


def test_without_a_file_a_table_is_shown(compiler, capsys):
    assert execute(["simulate", "rlc.acm"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("RLC - circuit: 0 s to 1 s, 5 points\n")
    assert "c.v       V" in out
    assert "0.841471" in out


def test_csv_on_standard_output(compiler, capsys):
    assert execute(["simulate", "rlc.acm", "--output", "-", "-v", "l.i"]) == 0
    rows = [x for x in capsys.readouterr().out.splitlines() if not x.startswith("#")]
    assert rows[:2] == ["time,l.i", "0.0,1.0"]


def test_plot_and_timings(compiler, capsys):
    assert execute(["simulate", "rlc.acm", "--plot", "run.png", "--timings"]) == 0
    assert Path("run.png").read_bytes().startswith(b"\x89PNG")
    err = capsys.readouterr().err
    assert "parse" in err
    assert "total" in err


@pytest.mark.parametrize(
    ("ending", "code"),
    [
        (Ending.COMPLETE, 0),
        (Ending.TERMINATED, 0),
        (Ending.FAILED, 3),
        (Ending.INTERRUPTED, 130),
    ],
)
def test_exit_codes_keep_what_was_computed(compiler, capsys, ending, code):
    compiler.ending = ending
    assert execute(["simulate", "rlc.acm", "--output", "run.csv"]) == code
    assert read_result("run.csv").ending is ending
    assert ("R101" in capsys.readouterr().err) is (ending is Ending.FAILED)


@pytest.mark.parametrize(
    "words",
    [
        "simulate",
        "simulate a.acm --points 1",
        "simulate a.acm --points 5 --interval 0.1",
        "simulate a.acm --interval 0",
        "simulate a.acm --stop soon",
        "simulate a.acm --stop 5[V]",
        "simulate a.acm --stop 5[sx]",
        "simulate a.acm --stop nan",
        "simulate a.acm --tolerance 0",
        "simulate a.acm --solver euler",
        "simulate a.acm -p R",
        "simulate a.acm -p 1R=3",
        "simulate a.acm -p R=",
        "simulate a.acm -p R=1 -p R=2",
        "simulate a.acm --plotting x",
        "simulat a.acm",
        "a.acm",
        "inspect a.acm --stage late",
        "messages Q1",
        "--nothing",
    ],
)
def test_wrong_command_lines(compiler, capsys, words):
    assert execute(words.split()) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Error: " in captured.err
    assert compiler.calls == []
    assert execute([*words.split(), "--json-errors"]) == 2
    data = json.loads(capsys.readouterr().err)
    assert data["diagnostics"][0]["code"] == "F401"


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ("simulate a.acm --output run.xls", "F201"),
        ("simulate a.acm --plot run.gif", "F201"),
        ("simulate a.acm --output none/run.csv", "F202"),
        ("simulate a.acm --plot .", "F201"),
        ("simulate a.acm -v nothing", "N901"),
        ("simulate a.acm -p huge=1 -o run.csv", "F206"),
        ("list Resistr", "N150"),
    ],
)
def test_coded_messages(compiler, capsys, words, code):
    assert execute(words.split()) == 1
    assert f"error[{code}]" in capsys.readouterr().err
    if code in ("F201", "F202"):
        assert compiler.calls == []


def test_errors_are_rendered_with_their_source(compiler, capsys):
    Path("a.acm").write_text("model A\n  Resistr r;\nend A;\n", encoding="utf-8")
    span = Span("a.acm", 2, 3, 2, 10)
    compiler.error = AcausalError([Diagnostic("N101", "there is no class Resistr", span)])
    for words in (["simulate", "a.acm"], ["check", "a.acm"]):
        assert execute(words) == 1
        assert " 2 |   Resistr r;\n   |   ^^^^^^^\n" in capsys.readouterr().err
    assert execute(["check", "a.acm", "--json-errors"]) == 1
    data = json.loads(capsys.readouterr().err)
    assert data["diagnostics"][0]["span"]["line"] == 2


def test_warnings_are_shown_and_do_not_fail(compiler, capsys, monkeypatch):
    warning = Diagnostic("C110", "left open", severity=Severity.WARNING)
    monkeypatch.setattr(
        Compiled, "warnings", property(lambda s: (warning,), lambda s, v: None), raising=False
    )
    assert execute(["simulate", "a.acm"]) == 0
    assert "warning[C110]: left open" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("error", "exit_code", "text"),
    [
        (KeyError("x"), 70, "F499"),
        (RecursionError("deep"), 70, "F499"),
        (MemoryError(), 1, "F402"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_no_traceback_ever(compiler, capsys, error, exit_code, text):
    compiler.error = error
    assert execute(["simulate", "a.acm"]) == exit_code
    err = capsys.readouterr().err
    assert text in err
    assert "Traceback" not in err


def test_check_and_inspect(compiler, capsys):
    assert execute(["check", "a.acm"]) == 0
    assert capsys.readouterr().out == "a.acm: 5 equations, 5 unknowns\n"
    assert execute(["inspect", "a.acm", "M", "--stage", "flatten", "--latex"]) == 0
    assert capsys.readouterr().out == "a.acm M flatten True\n"


def test_messages(capsys):
    assert execute(["messages"]) == 0
    everything = capsys.readouterr().out
    assert execute(["messages", "f120"]) == 0
    one = capsys.readouterr().out
    assert one.splitlines()[0] == "F: Files and command line"
    assert len(one.splitlines()) == 2
    assert one.splitlines()[1] in everything


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_has_examples(capsys, command):
    assert execute([*command, "--help"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Usage: acausal")
    assert "Examples:\n    acausal " in out


def test_version_names_sundials(capsys):
    assert execute(["--version"]) == 0
    out = capsys.readouterr().out
    assert out.startswith(f"acausal {acausal.version.__version__}\n")
    assert "SUNDIALS" in out


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("k=3", 3.0),
        ("k = 1e-3 ", 1e-3),
        ("k=1[kOhm]", "1[kOhm]"),
        ("k=true", "true"),
        ("k=inf", "inf"),
        ("k={1, 2}", "{1, 2}"),
        ("a.b[2].c=-4", -4.0),
    ],
)
def test_parameters(text, value):
    (found,) = read_parameters([text]).values()
    assert found == value
    assert type(found) is type(value)


def test_colors_only_on_a_terminal(compiler, capsys):
    compiler.error = AcausalError([Diagnostic("N101", "m")])
    execute(["check", "a.acm"])
    assert "\x1b" not in capsys.readouterr().err


def test_light_start():
    """What every command would pay for."""
    code = (
        "import sys, acausal; light = set(sys.modules)\n"
        "from acausal.cli.main import execute; execute(['--help'])\n"
        "heavy = {'numpy', 'scipy', 'lark', 'llvmlite', 'pint', 'matplotlib', 'rich', 'networkx'}\n"
        "print(sorted(heavy & set(sys.modules)), 'click' in light)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "[] False"


def test_a_closed_pipe_is_no_error():
    program = "from acausal.cli.main import run; run(['list', 'si', '--deep'])"
    run = subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert run.stdout is not None
    run.stdout.close()
    assert run.stderr is not None
    assert run.stderr.read() == b""
    run.wait()
