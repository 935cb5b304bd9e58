"""Derivatives that a parameter of the value zero multiplies are no derivatives of states."""

from __future__ import annotations

import numpy as np
import pytest

from acausal import compile_text
from acausal.diagnostics import AcausalError


def states(compiled) -> list[str]:
    system = compiled.system
    return sorted(
        system.names.variable(v)
        for v in np.flatnonzero((system.derivative >= 0) & system.active).tolist()
    )


def values(result, name: str) -> np.ndarray:
    return np.asarray(result[name].values)


DIVIDER = """
model Divider
  parameter Real C = 0;
  Real v(start = 0{fixed}), i;
equation
  C*der(v) = i;
  i = {jump} - 2*v;
end Divider;
"""


def test_a_capacitor_without_capacitance_follows_at_once():
    text = DIVIDER.format(fixed="", jump="(if time < 0.5 then 1 else 4)")
    compiled = compile_text(text)
    assert states(compiled) == []
    assert not compiled.warnings
    result = compiled.simulate(stop_time=1)
    t, v = result.times, values(result, "v")
    assert v[t < 0.4999] == pytest.approx(0.5)
    assert v[t > 0.5001] == pytest.approx(2)
    with_capacitance = compile_text(text, parameters={"C": 0.1})
    assert states(with_capacitance) == ["v"]


def test_a_fixed_start_is_taken_back_with_a_warning():
    compiled = compile_text(DIVIDER.format(fixed=", fixed = true", jump="1"))
    (warning,) = compiled.warnings
    assert warning.code == "I102"
    assert "for v" in warning.message
    assert warning.span is not None
    assert values(compiled.simulate(stop_time=1), "v") == pytest.approx(0.5)


def test_only_the_members_with_zero_are_changed():
    compiled = compile_text(
        """
model Row
  parameter Real C[4] = {0, 1, 0, 2};
  Real v[4](each start = 1), i[4];
equation
  for k in 1:4 loop
    C[k]*der(v[k]) = i[k];
    i[k] = -v[k];
  end for;
end Row;
"""
    )
    assert states(compiled) == ["v[2]", "v[4]"]
    result = compiled.simulate(stop_time=1, tolerance=1e-8)
    assert values(result, "v[1]") == pytest.approx(0, abs=1e-12)
    assert values(result, "v[4]")[-1] == pytest.approx(np.exp(-0.5), rel=1e-6)


def test_a_coefficient_that_is_a_variable():
    # c = C*(1 + v^2) is zero, so c*der(v) is.
    compiled = compile_text(
        """
model Junction
  parameter Real C = 0;
  Real v(start = 1), c;
equation
  c = C*(1 + v^2);
  c*der(v) = sin(time/1[s]) - v;
end Junction;
"""
    )
    assert states(compiled) == []
    result = compiled.simulate(stop_time=2)
    assert values(result, "v") == pytest.approx(np.sin(result.times))
    assert values(result, "c") == pytest.approx(0)


def test_a_charge_that_is_always_zero():
    compiled = compile_text(
        """
model Charge
  parameter Real C = 0;
  Real q, v(start = 1), i;
equation
  q = C*v;
  i = der(q);
  i = sin(time/1[s]) - v;
end Charge;
"""
    )
    assert states(compiled) == []
    result = compiled.simulate(stop_time=2)
    assert values(result, "v") == pytest.approx(np.sin(result.times))


def test_a_body_without_mass():
    # a = der(w) is an alias of a derivative: spring and damper decide, phi alone is a state.
    compiled = compile_text(
        """
model Massless
  parameter Real J = 0, c = 3, d = 2;
  Real phi(start = 1, fixed = true), w, a;
equation
  w = der(phi);
  a = der(w);
  J*a = -c*phi - d*w;
end Massless;
"""
    )
    assert not compiled.warnings
    result = compiled.simulate(stop_time=1, tolerance=1e-8)
    assert values(result, "phi") == pytest.approx(np.exp(-1.5 * result.times), rel=1e-6)
    assert values(result, "a") == pytest.approx(2.25 * np.exp(-1.5 * result.times), rel=1e-5)


def test_a_difference_of_parameters():
    compiled = compile_text(
        """
model Coils
  parameter Real L = 0.3, M = 0.3;
  Real i(start = 1);
equation
  (L - M)*der(i) = sin(time/1[s]) - i;
end Coils;
"""
    )
    assert states(compiled) == []
    result = compiled.simulate(stop_time=1)
    assert values(result, "i") == pytest.approx(np.sin(result.times))


def test_a_held_value_is_no_parameter():
    # b is zero at the start only.
    compiled = compile_text(
        """
model Held
  discrete Real b(start = 0, fixed = true);
  Real x(start = 1, fixed = true);
equation
  when time > 0.5 then
    b = 1;
  end when;
  (1 + b)*der(x) = -x;
end Held;
"""
    )
    assert states(compiled) == ["x"]
    compiled = compile_text(
        """
model Held
  discrete Real b(start = 0, fixed = true);
  Real x(start = 1, fixed = true), y;
equation
  when time > 0.5 then
    b = 1;
  end when;
  der(x) = -x;
  y = b*der(x);
end Held;
"""
    )
    result = compiled.simulate(stop_time=1, tolerance=1e-8)
    t, y = result.times, values(result, "y")
    assert y[t < 0.4999] == pytest.approx(0)
    assert y[t > 0.5001] == pytest.approx(-np.exp(-t[t > 0.5001]), rel=1e-6)


def test_other_products_with_zero_stay_in_the_structure():
    # R = 0 makes v zero, but nothing is differentiated: v stays what R*i defines.
    compiled = compile_text(
        """
model Short
  parameter Real R = 0;
  Real x(start = 1, fixed = true), v, i;
equation
  v = R*i;
  der(x) = v - x;
  i = x^3 + i^3/10;
end Short;
"""
    )
    assert 0 not in compiled.system.sign
    result = compiled.simulate(stop_time=1, tolerance=1e-8)
    assert values(result, "x")[-1] == pytest.approx(np.exp(-1), rel=1e-6)


def test_nothing_left_is_reported():
    with pytest.raises(AcausalError) as caught:
        compile_text(
            """
model Nothing
  parameter Real C = 0;
  Real v(start = 1);
equation
  C*der(v) = 0;
end Nothing;
"""
        )
    assert caught.value.diagnostics[0].code.startswith("S")


def test_a_start_value_stays_with_the_variable_that_stands_for_another() -> None:
    # Td = 0 makes w and v one variable, for which v stands: the fixed start of w is that of a state
    # all the same.
    compiled = compile_text("""
model M
  parameter Real J = 25, Td = 0;
  Real w(start = 2, fixed = true), v(stateSelect = StateSelect.prefer), e, d, a, f;
equation
  f = Td*der(v);
  v = w + f;
  e = -w;
  a = der(w);
  J*a = 10*e;
  d = v;
end M;
""")
    assert not compiled.warnings
    result = compiled.simulate(stop_time=1.0, tolerance=1e-9)
    assert result["d"].values[-1] == pytest.approx(2 * np.exp(-10 / 25), rel=1e-6)
