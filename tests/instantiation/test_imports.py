"""Imports of all forms, packages on disk and in the file, the order in which names are sought."""

from __future__ import annotations

from pathlib import Path

import pytest

from acausal.diagnostics import AcausalError
from acausal.flattening.flatten import flatten
from acausal.instantiation.instantiate import instantiate
from acausal.modeling.load import choose_model, load_file
from tests.flattening.static import solve_flat

FILES = {
    "lib/a.acm": (
        "model A Real x = 1; end A; model A2 extends A; Real y = 2*x; end A2; "
        "function twice input Real x; output Real y; algorithm y := 2*x; end twice;"
    ),
    "lib/b.acm": "model B A a; Real z = a.x + sub.C.k; end B;",
    "lib/sub/c.acm": (
        "package C constant Real k = 7; constant Real double = 2*k; end C; "
        "model D B b; Real w = C.double; end D; type E = enumeration(one, two); "
        "model A Real x = 100; end A;"
    ),
    "single.acm": "package single model S Real s = 4; end S; end single;",
}


@pytest.fixture
def run(tmp_path: Path):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)

    def solve(text: str) -> dict[str, float]:
        path = tmp_path / "model.acm"
        path.write_text(text)
        classes, _ = load_file(path)
        templates, left = instantiate(choose_model(classes, None, "file"), {})
        return solve_flat(flatten(templates, left))

    return solve


@pytest.mark.parametrize(
    ("text", "path", "value"),
    [
        ("model M lib.A a; end M;", "a.x", 1),
        ("import lib; model M lib.A2 a; end M;", "a.y", 2),
        ("import lib.A; model M A a; end M;", "a.x", 1),
        ("import L = lib.sub; model M L.D d; end M;", "d.w", 14),
        ("import Q = lib.A2; model M Q a; end M;", "a.y", 2),
        ("import lib.{A, B}; model M A a; B b; end M;", "b.z", 8),
        ("import lib.*; model M B b; sub.D d; end M;", "d.b.z", 8),
        ("import lib.*; model M Real q = twice(3); end M;", "q", 6),
        ("model M import lib.A; A a; end M;", "a.x", 1),
        ("model M import lib.sub.*; D d; Real k = C.k; end M;", "k", 7),
        ("import lib.sub.C.k; model M Real x = k; end M;", "x", 7),
        ("import lib.sub.C.*; model M Real x = k + double; end M;", "x", 21),
        (
            "import lib.sub.E; model M parameter E e = E.two; "
            "Real x = if e == E.two then 1 else 0; end M;",
            "x",
            1,
        ),
        ("model M single.S s; end M;", "s.s", 4),
        ("model M Real lib = 3; lib.A a; end M;", "a.x", 1),
        ("model M extends lib.A2(x = 9); end M;", "y", 18),
        ("within lib; model M A a; sub.D d; end M;", "d.w", 14),
        # A qualified import is seen before a wildcard, the file's own class before both.
        ("import lib.sub.*; import lib.A; model M A a; end M;", "a.x", 1),
        ("import lib.*; model A Real x = 5; end A; model M A a; end M;", "a.x", 5),
        # Packages of the file itself.
        ("package P model A Real x = 3; end A; end P; model M import P.*; A a; end M;", "a.x", 3),
        ("import P.A; package P model A Real x = 3; end A; end P; model M A a; end M;", "a.x", 3),
        ("package P model A Real x = 3; end A; end P; model M .P.A a; end M;", "a.x", 3),
        (
            (
                "package P model A Real x = k; end A; constant Real k = 6; "
                "end P; model M P.A a; end M;"
            ),
            "a.x",
            6,
        ),
        # A nested class sees the constants around it.
        ("model M constant Real q = 6; model I Real x = q; end I; I i; end M;", "i.x", 6),
    ],
)
def test_names_are_found(run, text, path, value):
    assert run(text)[path] == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "code", "hint"),
    [
        ("import lib.Ax; model M Ax a; end M;", "N107", "A"),
        ("import libx.*; model M A a; end M;", "N107", "lib"),
        ("model M lib.Ax a; end M;", "N101", "A"),
        ("model M lib.sub.Dd d; end M;", "N101", "D"),
        ("model M lib a; end M;", "N110", ""),
        ("model M lib.twice a; end M;", "N110", ""),
        ("import lib.*; import lib.sub.*; model M A a; end M;", "N121", ""),
        # Imports are not inherited, and a nested class sees no parameters.
        ("model N import lib.A2; A2 q; end N; model M extends N; A2 r; end M;", "N101", ""),
        ("model M parameter Real k = 5; model I Real x = k; end I; I i; end M;", "N112", ""),
        ("model M Real x = lib.sub.C.kk; end M;", "N102", ""),
        ("model A extends B; end A; model B extends A; end B; model M A a; end M;", "N104", ""),
    ],
)
def test_names_that_mean_nothing(run, text, code, hint):
    with pytest.raises(AcausalError) as caught:
        run(text)
    message = caught.value.diagnostics[0]
    assert message.code == code
    assert message.span is not None and message.help
    if hint:
        assert hint in " ".join(message.notes)


def test_nothing_is_read_before_it_is_asked_for(run, tmp_path):
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "x.acm").write_text("model ( end")
    assert run("model M lib.A a; end M;")["a.x"] == pytest.approx(1.0)


def test_one_name_in_two_files_of_a_package(run, tmp_path):
    (tmp_path / "lib" / "z.acm").write_text("model A Real x = 2; end A;")
    with pytest.raises(AcausalError) as caught:
        run("model M lib.A a; end M;")
    assert caught.value.diagnostics[0].code == "N105"
