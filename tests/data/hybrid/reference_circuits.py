"""Circuits with ideal diodes and switches: linear between switchings.

A diode or switch is a branch with two straight lines: with the parameter s, while it is off
``v = s, i = Goff s`` (s < 0), while it is on ``v = Ron s, i = s`` (s > 0), and s changes
sign continuously.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from integrate_modes import Array, Guard, Mode, integrate
from scipy.linalg import expm
from scipy.optimize import brentq

R_ON, G_OFF = 1e-5, 1e-5


def full_wave_bridge() -> dict[str, Any]:
    """A sine source with a series resistor feeds a capacitor and a load through four diodes.

    The minus rail is ground. Unknown potentials a, b of the source's ends; v of the capacitor.
    Diodes: a -> plus, b -> plus, ground -> a, ground -> b.
    """
    amplitude, frequency, r_source, c, r_load = 10.0, 50.0, 1.0, 1e-3, 100.0

    def source(t: float) -> float:
        return amplitude * np.sin(2 * np.pi * frequency * t)

    def solve(on: tuple[bool, ...], t: float, v: float) -> tuple[Array, float, float, float]:
        """Return the parameters s of the diodes, the source current and both potentials."""
        # Unknowns: s1..s4, i, a, b
        matrix, right = np.zeros((7, 7)), np.zeros(7)
        # v_k = (1 or Ron) s_k: a - v, b - v, -a, -b
        for k, (sign_a, sign_b, plus) in enumerate(((1, 0, 1), (0, 1, 1), (-1, 0, 0), (0, -1, 0))):
            matrix[k, k] = -(R_ON if on[k] else 1.0)
            matrix[k, 5], matrix[k, 6] = sign_a, sign_b
            right[k] = plus * v
        flow = [1.0 if o else G_OFF for o in on]
        matrix[4, [0, 2, 4]] = flow[0], -flow[2], -1  # i = i1 - i3 at a
        matrix[5, [1, 3, 4]] = flow[1], -flow[3], 1  # -i = i2 - i4 at b
        matrix[6, [4, 5, 6]] = r_source, 1, -1
        right[6] = source(t)
        z = np.linalg.solve(matrix, right)
        return z[:4], float(z[4]), float(z[5]), float(z[6])

    def consistent(t: float, v: float) -> tuple[bool, ...]:
        """Return the one combination of diode states whose s have the right signs."""
        found = [
            on for on in product((False, True), repeat=4)
            if all((s > 0) == o for s, o in zip(solve(on, t, v)[0], on, strict=True))
        ]  # fmt: skip
        assert len(found) == 1, (t, v, found)
        return found[0]

    def name(on: tuple[bool, ...]) -> str:
        return "".join("1" if o else "0" for o in on)

    def mode(on: tuple[bool, ...]) -> Mode:
        def slope(t: float, z: Array) -> Array:
            s = solve(on, t, z[0])[0]
            charge = sum(x * (1.0 if o else G_OFF) for x, o in zip(s[:2], on[:2], strict=True))
            return np.array([(charge - z[0] / r_load) / c])

        def guard(k: int) -> Guard:
            def action(t: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
                # By symmetry two diodes change at once; the state just after tells which.
                after = consistent(t + 1e-10, float(z[0] + 1e-10 * slope(t, z)[0]))
                return name(after), z, {"diodes": name(after)}

            return Guard(lambda t, z: solve(on, t, z[0])[0][k], -1 if on[k] else 1, action)

        return Mode(slope, [guard(k) for k in range(4)])

    modes = {name(on): mode(on) for on in product((False, True), repeat=4)}
    times = np.linspace(0, 0.1, 101) + 1.234e-5
    times[0], times[-1] = 0.0, 0.1
    values, events = integrate(modes, name(consistent(1e-9, 0.0)), [0.0], times, 1e-4)
    currents = []
    for t, v in zip(times[1:], values[1:, 0], strict=True):
        on = consistent(t, v)
        s, i, a, b = solve(on, t, v)
        flow = [x * (1.0 if o else G_OFF) for x, o in zip(s, on, strict=True)]
        currents.append([i, a, b, *flow])
    return {
        "parameters": {
            "amplitude": amplitude, "frequency": frequency, "Rs": r_source, "C": c,
            "R": r_load, "Ron": R_ON, "Goff": G_OFF, "v0": 0.0,
        },
        "convention": "i flows out of the source into a; v(source) = a - b + Rs i",
        "variables": ["v"],
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
        "algebraic_variables": ["i", "a", "b", "i1", "i2", "i3", "i4"],
        "algebraic_from_second_time": currents,
    }  # fmt: skip


def half_wave() -> dict[str, Any]:
    """Sine source, diode, capacitor with load: the diode sees the difference of the voltages."""
    amplitude, frequency, r_source, c, r_load = 10.0, 50.0, 1.0, 1e-3, 100.0

    def parameter(on: bool, t: float, v: float) -> float:
        drive = amplitude * np.sin(2 * np.pi * frequency * t) - v
        return float(drive / (r_source + R_ON) if on else drive / (1 + r_source * G_OFF))

    def mode(on: bool) -> Mode:
        def slope(t: float, z: Array) -> Array:
            i = parameter(on, t, z[0]) * (1.0 if on else G_OFF)
            return np.array([(i - z[0] / r_load) / c])

        guard = Guard(
            lambda t, z: parameter(on, t, z[0]), -1 if on else 1,
            lambda t, z: ("off" if on else "on", z, {}),
        )  # fmt: skip
        return Mode(slope, [guard])

    times = np.linspace(0, 0.2, 101) + 1.234e-5
    times[0], times[-1] = 0.0, 0.2
    modes = {"on": mode(True), "off": mode(False)}
    values, events = integrate(modes, "on", [0.0], times, 1e-4)
    return {
        "parameters": {
            "amplitude": amplitude, "frequency": frequency, "Rs": r_source, "C": c,
            "R": r_load, "Ron": R_ON, "Goff": G_OFF, "v0": 0.0,
        },
        "variables": ["v"],
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
    }  # fmt: skip


class Buck:
    """Buck converter: source, switch to node x, diode ground -> x, coil, capacitor, load.

    Unknowns i (coil) and v (capacitor); with node potential x: L i' = x - R_L i - v,
    C v' = i - v/R.
    """

    def __init__(self, load: float) -> None:
        self.source, self.coil, self.coil_r, self.c, self.load = 24.0, 100e-6, 0.05, 100e-6, load
        self.frequency, self.duty = 50e3, 0.4

    def node(self, switch: bool, diode: bool) -> tuple[float, float]:
        """Return x = a + b i of a mode: conductances of switch and diode meet the coil current."""
        g = (1 / R_ON if switch else G_OFF), (1 / R_ON if diode else G_OFF)
        return g[0] * self.source / sum(g), -1 / sum(g)

    def system(self, switch: bool, diode: bool) -> tuple[Array, Array]:
        """Return A and b of z' = A z + b."""
        a, b = self.node(switch, diode)
        matrix = np.array([
            [(b - self.coil_r) / self.coil, -1 / self.coil],
            [1 / self.c, -1 / (self.load * self.c)],
        ])  # fmt: skip
        return matrix, np.array([a / self.coil, 0.0])

    def after(self, switch: bool, diode: bool, z: Array, t: float) -> Array:
        """Return the values a time t later in a mode, by the matrix exponential."""
        matrix, right = self.system(switch, diode)
        rest = -np.linalg.solve(matrix, right)
        return np.asarray(rest + expm(matrix * t) @ (z - rest))

    def period(self, z: Array) -> tuple[Array, list[float], Array]:
        """Return values after a period from switching on, event times in it, values at off."""
        total = 1 / self.frequency
        on = self.duty * total
        peak = self.after(True, False, z, on)
        # The diode blocks where its current falls through zero: x = a + b i rises through 0.
        a, b = self.node(False, True)

        def through(t: float) -> float:
            # Diode: s = i_d = -x/Ron while on
            return float(-(a + b * self.after(False, True, peak, t)[0]))

        rest = total - on
        if through(rest) >= 0:
            return self.after(False, True, peak, rest), [on], peak
        off = float(brentq(through, 0.0, rest, xtol=1e-18, rtol=1e-15))
        blocked = self.after(False, True, peak, off)
        # With both off the node follows v; the diode would conduct again if x fell below 0.
        return self.after(False, False, blocked, rest - off), [on, on + off], peak


def buck(load: float) -> dict[str, Any]:
    """Start from zero, and the periodic solution, both by matrix exponentials.

    The switch is on during [k T, k T + d T). With a small load current the coil current falls to
    zero in every period (discontinuous conduction), an additional state event.
    """
    b = Buck(load)
    z, ends, events = np.zeros(2), [], []
    for k in range(500):
        z, inner, _ = b.period(z)
        if k < 40:
            events.append([(k / b.frequency) + t for t in inner])
        ends.append(z.tolist())
    steady = z
    # Newton on the map of a period, differences for its matrix.
    for _ in range(8):
        image = b.period(steady)[0]
        columns = [(b.period(steady + 1e-6 * e)[0] - image) / 1e-6 for e in np.eye(2)]
        steady = steady - np.linalg.solve(np.array(columns).T - np.eye(2), image - steady)
    again, inner, peak = b.period(steady)
    np.testing.assert_allclose(again, steady, rtol=1e-10)
    return {
        "parameters": {
            "source": b.source, "L": b.coil, "R_L": b.coil_r, "C": b.c, "R": load,
            "frequency": b.frequency, "duty": b.duty, "Ron": R_ON, "Goff": G_OFF,
            "i0": 0.0, "v0": 0.0,
        },
        "variables": ["i", "v"],
        "periods": len(ends),
        "at_end_of_period": ends,
        "event_times_first_periods": events,
        "steady_start_of_period": steady.tolist(),
        "steady_switch_off": peak.tolist(),
        "steady_event_times_in_period": inner,
    }  # fmt: skip


#: For readers: the two loads of the file.
LOADS: dict[str, float] = {"continuous": 5.0, "discontinuous": 200.0}
