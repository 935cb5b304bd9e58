"""The solenoid valve: it opens and closes, and no energy is lost on the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from acausal import compile_text

EXAMPLE = Path(__file__).parents[2] / "examples" / "solenoid_valve.acm"
BALANCE = """
model Balance
  extends SolenoidValve;
  Real electric(start = 0, fixed = true) "energy from the supply";
  Real heat(start = 0, fixed = true) "in the winding";
  Real magnetic_(start = 0, fixed = true) "work of the magnet on the plunger";
  Real oilWork(start = 0, fixed = true) "work of the oil on the cone";
  Real damped(start = 0, fixed = true) "in the damper";
  Real filled(start = 0, fixed = true) "volume through the seat";
  Real left(start = 0, fixed = true) "volume through the load";
equation
  der(electric) = -supply.v*supply.i;
  der(heat) = winding.R*coil.i^2;
  der(magnetic_) = gap.F_m*plunger.v;
  der(oilWork) = -seat.flange.f*plunger.v;
  der(damped) = spring.d*plunger.v^2;
  der(filled) = seat.q;
  der(left) = load.q;
end Balance;
"""


def test_energy_balance_of_the_solenoid_valve() -> None:
    text = EXAMPLE.read_text(encoding="utf-8") + BALANCE
    result = compile_text(text, model="Balance").simulate(
        stop_time=0.1, points=2001, tolerance=1e-9
    )

    def v(name: str) -> np.ndarray:
        return np.asarray(result[name].values)

    time, lift = result.times, v("plunger.s")
    # shut, open, shut again, with the delays of the current
    assert lift[time < 0.02] == pytest.approx(0, abs=1e-9)
    assert lift[(time > 0.03) & (time < 0.06)] == pytest.approx(0.5e-3, abs=1e-9)
    assert lift[time > 0.08] == pytest.approx(0, abs=1e-9)
    assert v("consumer.p")[(time > 0.04) & (time < 0.06)].min() > 28e5
    assert v("consumer.p")[-1] == pytest.approx(101325, rel=1e-4)
    # the current falls while the plunger moves
    moving = (lift > 0.05e-3) & (lift < 0.45e-3) & (time < 0.03)
    assert np.diff(v("coil.i")[moving]).min() < 0
    # what the supply gives is heat, field, and work
    field = 3e6 * v("iron.Phi") ** 2 / 2 + v("gap.Phi") ** 2 / v("gap.G_m") / 2
    given = v("electric")
    assert given == pytest.approx(v("heat") + field + v("magnetic_"), abs=1e-6 * given.max())
    # the work goes into spring, motion and damper; each impact takes the rest of it
    kinetic = 0.02 * v("plunger.v") ** 2 / 2
    preload, c = 18.0, 5e3
    spring = c * ((lift + preload / c) ** 2 - (preload / c) ** 2) / 2
    lost = v("magnetic_") + v("oilWork") - kinetic - spring - v("damped")
    scale = v("magnetic_").max()
    assert np.diff(lost).min() > -1e-5 * scale
    impacts = np.diff(lost) > 1e-3 * scale
    assert 2 <= impacts.sum() <= 20
    assert lost[(time > 0.03) & (time < 0.059)] == pytest.approx(lost[time < 0.04][-1], rel=1e-5)
    # oil that came and did not go was pressed together
    stored = (v("consumer.p") - 101325).max()
    assert stored > 0
    assert abs((v("filled") - v("left"))[-1]) < 1e-3 * v("filled")[-1]
