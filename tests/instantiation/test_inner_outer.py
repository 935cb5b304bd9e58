"""Inner and outer: the nearest inner one counts, components as well as single variables."""

from __future__ import annotations

import pytest

from tests.flattening.static import refused, solve

WORLD = """
model World parameter Real g = 9; Real h = 2*g; end World;
model User outer World world; Real x = world.g + world.h; end User;
"""


def test_every_user_sees_the_one_inner():
    found = solve(WORLD + "model M inner World world(g = 5); User a; User b[2]; end M;")
    assert [found[f"{n}.x"] for n in ("a", "b[1]", "b[2]")] == pytest.approx([15.0] * 3)


def test_the_nearest_inner_counts():
    found = solve(
        WORLD + "model Room inner World world(g = 1); User a; User c[2]; end Room; "
        "model M inner World world(g = 5); User a; Room b; Room d[2](world(g = {7, 8})); end M;"
    )
    assert found["a.x"] == pytest.approx(15.0)
    assert [found[f"b.{n}.x"] for n in ("a", "c[1]", "c[2]")] == pytest.approx([3.0] * 3)
    assert [found[f"d[{k}].a.x"] for k in (1, 2)] == pytest.approx([21.0, 24.0])
    assert [found[f"d[{k}].c[2].x"] for k in (1, 2)] == pytest.approx([21.0, 24.0])


def test_outer_reaches_through_levels_that_do_not_know_it():
    found = solve(WORLD + "model Box User u; end Box; model M inner World world; Box b[2]; end M;")
    assert found["b[2].u.x"] == pytest.approx(27.0)


def test_a_model_can_be_both():
    found = solve(
        WORLD + "model Room inner outer World world; User a; end Room; "
        "model M inner World world(g = 5); Room b; end M;"
    )
    assert found["b.a.x"] == pytest.approx(27.0)


def test_cuts_of_an_outer_component():
    pin = "connector Pin Real v; flow Real i; end Pin;\n"
    found = solve(
        pin + "model Bus Pin p; equation p.v = 12; end Bus; "
        "model R Pin p; equation p.v = 3*p.i; end R; "
        "model Load outer Bus bus; R r; equation connect(r.p, bus.p); end Load; "
        "model M inner Bus bus; Load a; Load b[2]; end M;"
    )
    assert found["b[2].r.p.i"] == pytest.approx(4.0)
    assert found["bus.p.i"] == pytest.approx(-12.0)


def test_variables_and_parameters():
    found = solve(
        "model A outer Real T; outer parameter Integer n; Real x[n] = fill(T, n); end A; "
        "model B inner Real T = 8; A a; end B; "
        "model M inner Real T = 3; inner parameter Integer n = 2; A a; B b; end M;"
    )
    assert (found["a.x[2]"], found["b.a.x[1]"]) == pytest.approx((3.0, 8.0))


def test_an_outer_variable_can_be_an_array_and_can_be_determined_inside():
    found = solve(
        "model A outer Real v[3]; Real x = v[2] + sum(v); end A; "
        "model B outer Real y; equation y = 7; end B; "
        "model M inner Real v[3] = {1, 2, 3}; inner Real y; A a; B b; end M;"
    )
    assert (found["a.x"], found["y"]) == pytest.approx((8.0, 7.0))


@pytest.mark.parametrize("kind", ["World", "Real", "parameter Real"])
def test_a_missing_inner_is_named_with_the_line_to_write(kind):
    message = refused(
        f"model World end World; model A outer {kind} world; end A; model M A a; end M;"
    )
    assert message.code == "N118"
    assert f"inner {kind.split()[-1]} world;" in message.help
