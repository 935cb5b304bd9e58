"""Native functions written by hand."""

from __future__ import annotations

import ctypes
import itertools

import numpy as np

from acausal.codegen import engine
from acausal.codegen.writer import Function, module

_numbers = itertools.count()
_NATIVE = {"double": ctypes.c_double, "i64": ctypes.c_int64, "ptr": ctypes.c_void_p}


def compiled(function: Function, result: str, *kinds: str):
    text = module(function).replace("@test(", f"@test{(number := next(_numbers))}(")
    engine.load_objects([engine.compile_object(text, level=2, passes=True)])
    prototype = ctypes.CFUNCTYPE(_NATIVE[result], *(_NATIVE[kind] for kind in kinds))
    return prototype(engine.address_of(f"test{number}"))


def test_loop_over_an_array():
    f = Function("test", "double", x="ptr", n="i64")
    total = f.variable("double", 0.0)
    with f.loop(f["n"]) as k:
        value = f.load(f["x"], k)
        with f.when(value > 0.0):
            total.set(total + f.real(k) * value)
    f.give(total)
    x = np.array([1.0, 2.0, -7.0, 4.0])
    assert compiled(f, "double", "ptr", "i64")(x.ctypes.data, 4) == 2.0 + 3 * 4.0


def test_euclid():
    f = Function("test", "i64", a="i64", b="i64")
    a, b = f.variable("i64", f["a"]), f.variable("i64", f["b"])
    with f.while_(lambda: a.differs(b)):
        small, large = f.smaller(a, b), f.larger(a, b)
        a.set(small)
        b.set(large - small)
        with f.when(b.equals(0)):
            f.give(a)
    f.give(a)
    assert compiled(f, "i64", "i64", "i64")(84, 36) == 12


def test_nan_compares_false_and_differs():
    f = Function("test", "i64", x="double")
    x = f["x"]
    code = f.variable("i64", 0)
    with f.when((x < 1.0) | (x >= 1.0) | x.equals(x)):
        code.set(code + 1)
    with f.when(x.differs(x) & ~(x > 0.0)):
        code.set(code + 2)
    f.give(code)
    function = compiled(f, "i64", "double")
    assert (function(float("nan")), function(0.5)) == (2, 1)


def test_reals_and_arrays():
    f = Function("test", "double", to="ptr", source="ptr", n="i64")
    f.copy(f["to"], f["source"], f["n"])
    f.store(f["to"], 0, f.sqrt(f.abs(f.load(f["source"], 0))))
    f.give(1.0 / f.load(f["to"], 1) - 0.25)
    to, source = np.zeros(3), np.array([-16.0, 2.0, 5.0])
    assert compiled(f, "double", "ptr", "ptr", "i64")(to.ctypes.data, source.ctypes.data, 3) == 0.25
    np.testing.assert_array_equal(to, [4.0, 2.0, 5.0])
