"""Finding, loading and questioning SUNDIALS' libraries."""

import pickle
import subprocess
import sys
import warnings

import pytest

from acausal.diagnostics import AcausalError
from acausal.solvers.sundials import binding, locate

FOUND = [location.source for location in locate.locations()]


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("libsundials_idas-cf62a44f.so.6.6.0", "idas"),
        ("libsundials_sunlinsolklu.so", "sunlinsolklu"),
        ("libsundials_ida.7.9.0.dylib", "ida"),
        ("libsundials_core.dylib", "core"),
        ("sundials_nvecserial-0123456789abcdef0123456789abcdef.dll", "nvecserial"),
        ("libsundials_ida.a", None),
        ("libother_ida.so", None),
    ],
)
def test_file_names(tmp_path, name, part):
    (tmp_path / name).touch()
    assert list(locate._files(tmp_path)) == ([part] if part else [])


def test_shortest_of_several_versions(tmp_path):
    for name in ("libsundials_ida.so.6.4.1", "libsundials_ida.so", "libsundials_ida.so.6"):
        (tmp_path / name).touch()
    assert locate._files(tmp_path)["ida"].name == "libsundials_ida.so"


def test_incomplete_folder_is_refused(tmp_path):
    (tmp_path / "libsundials_ida.so").touch()
    with pytest.raises(AcausalError) as caught:
        locate.choose(str(tmp_path))
    assert caught.value.diagnostics[0].code == "R101"
    assert "pip install" in caught.value.diagnostics[0].help


def test_unknown_source_is_refused(monkeypatch):
    monkeypatch.setenv(locate.VARIABLE, "nonsense")
    with pytest.raises(AcausalError, match="nonsense"):
        locate.choose()


def test_file_that_is_no_library(tmp_path):
    for part in ("ida", "nvecserial", "sunmatrixdense", "sunmatrixsparse", "sunlinsoldense"):
        (tmp_path / f"libsundials_{part}.so").write_text("not a library")
    (tmp_path / "libsundials_sunlinsolklu.so").touch()
    with pytest.raises(AcausalError) as caught:
        locate.Sundials(locate.choose(str(tmp_path)))
    assert "cannot load" in caught.value.diagnostics[0].message


@pytest.mark.parametrize("source", FOUND)
def test_every_source_answers(source):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        library = binding.bind(source)
    assert library.index_bytes in (4, 8)
    assert (6, 0, 0) <= library.sundials.version < (8, 0, 0)
    text = library.sundials.describe()
    assert source in text
    assert library.sundials.version_text in text


def test_something_is_found():
    assert FOUND, "the base dependency carries SUNDIALS"
    assert locate.describe().startswith("SUNDIALS ")


def test_describe_tells_when_there_is_none(monkeypatch):
    monkeypatch.setenv(locate.VARIABLE, "nonsense")
    locate.load.cache_clear()
    binding.bind.cache_clear()
    try:
        assert locate.describe().startswith("no SUNDIALS")
    finally:
        locate.load.cache_clear()
        binding.bind.cache_clear()


def test_nothing_heavy_is_imported():
    """Locating must not import the packages that carry the libraries, nor SciPy."""
    code = (
        "import sys, acausal.solvers.sundials as s; s.describe(); import acausal.solvers.ida;"
        "print([m for m in ('casadi', 'pybammsolvers', 'sksundae', 'scipy') if m in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


def test_errors_survive_pickling():
    from acausal.solvers.failures import Failure, Reason, integration_error
    from acausal.solvers.protocol import NumberLabels

    error = integration_error(Failure(Reason.SINGULAR, 1.0, 1e-3, (2,), (1,)), NumberLabels())
    copy = pickle.loads(pickle.dumps(error))
    assert copy.failure == error.failure
    assert copy.diagnostics == error.diagnostics
    assert "y[2]" in copy.diagnostics[0].notes[0]
