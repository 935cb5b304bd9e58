"""Files written while a run goes on."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys

import numpy as np
import pytest

import acausal as ac
from acausal.results import Ending, Result, read_result, stream
from acausal.simulation import output

FORMATS = ["run.csv", "run.nc", "run.h5", "run.parquet"]
MODEL = """
model Sawtooth "rises and falls"
  parameter Real rate(unit = "1/s") = 2 "slope";
  Real x(start = 0, fixed = true, unit = "m") "height";
  Real y[2] = {x, -x};
  discrete Real side(start = 1, fixed = true);
equation
  der(x) = side*rate*1[m];
  when x > 1 then
    side = -1;
  elsewhen x < 0 then
    side = 1;
  end when;
end Sawtooth;
"""


@pytest.fixture(scope="module")
def compiled():
    return ac.compile_text(MODEL)


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr(output, "WRITTEN", 200)


def same(back: Result, result: Result) -> None:
    np.testing.assert_array_equal(back.times, result.times)
    assert sorted(back.variables.paths()) == sorted(result.variables.paths())
    for path in result.variables.paths():
        np.testing.assert_array_equal(back[path].values, result[path].values)
        assert back[path].unit == result[path].unit
        assert back[path].description == result[path].description
    assert tuple(back.events) == tuple(result.events)
    assert dict(back.parameters) == dict(result.parameters)
    assert back.parameter_units["rate"] == result.parameter_units["rate"] == "1/s"
    assert back.model_name == result.model_name
    assert back.description == result.description
    assert back.experiment == result.experiment
    assert back.ending is result.ending
    assert [d.message for d in back.diagnostics] == [d.message for d in result.diagnostics]


@pytest.mark.parametrize("name", FORMATS)
def test_a_plain_file_reads_back_as_the_same_result(compiled, tmp_path, name):
    result = compiled.simulate(stop_time=3.0)
    result.write(tmp_path / name)
    same(read_result(tmp_path / name), result)


@pytest.mark.parametrize("keep", [True, False])
@pytest.mark.parametrize("name", FORMATS)
def test_a_stream_reads_back_as_the_same_result(compiled, tmp_path, name, keep, small_chunks):
    plain = compiled.simulate(stop_time=3.0)
    assert len(plain.events) >= 5
    streamed = compiled.simulate(stop_time=3.0, output=tmp_path / name, keep=keep)
    same(read_result(tmp_path / name), plain)
    same(streamed, plain)
    assert streamed.find("y[*]") == ["y[1]", "y[2]"]
    assert streamed.evaluate("y[1] - y[2]").max() == pytest.approx(2, rel=1e-6)
    assert os.listdir(tmp_path) == [name]


def test_chosen_variables_only(compiled, tmp_path, small_chunks):
    compiled.simulate(stop_time=1.0, output=tmp_path / "a.nc", keep=False, variables=["y[2]*2"])
    assert list(read_result(tmp_path / "a.nc").variables.paths()) == ["y[2]"]


def test_memory_holds_nothing(compiled, tmp_path, small_chunks):
    result = compiled.simulate(stop_time=1.0, output=tmp_path / "a.parquet", keep=False)
    assert isinstance(result.variables, stream.StreamedSource)
    with pytest.raises(ac.AcausalError) as error:
        result["z"]
    assert error.value.diagnostics[0].code == "N901"
    with pytest.raises(ac.AcausalError) as error:
        compiled.simulate(stop_time=1.0, keep=False)
    assert error.value.diagnostics[0].code == "R010"
    with pytest.raises(ac.AcausalError) as error:
        compiled.simulate(stop_time=1.0, output=tmp_path / "none" / "a.nc")
    assert error.value.diagnostics[0].code == "F202"


@pytest.mark.parametrize("name", FORMATS)
def test_a_full_disk_leaves_a_complete_file(compiled, tmp_path, name, small_chunks, monkeypatch):
    # Growing HDF5 files write their last chunk again and again.
    room, genuine = [{".csv": 8_000, ".parquet": 30_000}.get(name[3:], 400_000)], os.write

    def write(number: int, data: memoryview) -> int:
        reserved = any(p.suffix == ".reserve" for p in tmp_path.iterdir())
        if reserved and len(data) > room[0]:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        room[0] -= len(data)
        return genuine(number, data)

    monkeypatch.setattr(stream.os, "write", write)
    result = compiled.simulate(stop_time=40.0, points=4001, output=tmp_path / name, keep=False)
    assert result.ending is Ending.FAILED
    assert [d.code for d in result.diagnostics if d.code[0] == "F"] == ["F207"]
    assert "points up to" in result.diagnostics[-1].notes[0]
    back = read_result(tmp_path / name)
    assert 10 < len(back.times) < 4001
    assert back.ending is Ending.FAILED
    np.testing.assert_array_equal(result.times, back.times)
    np.testing.assert_allclose(back["y[1]"].values, back["x"].values)
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("name", FORMATS)
def test_an_interruption_leaves_a_complete_file(compiled, tmp_path, name, small_chunks):
    def progress(now: float, stop: float) -> None:
        if now > 2.0:
            raise KeyboardInterrupt

    # Wherever the interruption is met, the file is there and whole.
    try:
        result = compiled.simulate(
            stop_time=50.0, points=5001, output=tmp_path / name, keep=False, progress=progress
        )
    except KeyboardInterrupt:
        result = None
    back = read_result(tmp_path / name)
    assert back.ending is Ending.INTERRUPTED
    assert 1 < len(back.times) < 5001
    assert result is None or result.ending is Ending.INTERRUPTED
    assert os.listdir(tmp_path) == [name]


@pytest.mark.parametrize("name", ["run.csv", "run.nc"])
def test_a_killed_process_leaves_what_it_wrote(tmp_path, name):
    program = (
        "import os, sys, signal, acausal as ac\n"
        "from acausal.simulation import output\n"
        "output.WRITTEN = 2000\n"
        "def progress(now, stop):\n"
        "    if now > 20.0: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"ac.compile_text({MODEL!r}).simulate(stop_time=50.0, points=20001, output=sys.argv[1],"
        " keep=False, progress=progress)\n"
    )
    run = subprocess.run([sys.executable, "-c", program, str(tmp_path / name)], check=False)
    assert run.returncode == -signal.SIGKILL
    back = read_result(tmp_path / name)
    assert back.ending is Ending.INTERRUPTED
    assert len(back.times) > 1000
    np.testing.assert_allclose(back["y[1]"].values, back["x"].values)


def test_no_space_at_all(compiled, tmp_path, monkeypatch):
    def refuse(number: int, first: int, size: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(stream.os, "posix_fallocate", refuse)
    with pytest.raises(ac.AcausalError) as error:
        compiled.simulate(stop_time=1.0, output=tmp_path / "a.nc")
    assert error.value.diagnostics[0].code == "F203"
