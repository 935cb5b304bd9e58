"""Right-hand sides that jump: sliding along the surface of the jump, sticking and slipping."""

from __future__ import annotations

from typing import Any

import numpy as np
from integrate_modes import Array, Guard, Mode, integrate


def agree(a: Any, b: Any) -> None:
    """Two derivations of the same numbers must give the same."""
    np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-10)


def relay() -> dict[str, Any]:
    """x' = -1 if x > 0 else 1, x(0) = 0.5: zero from t = 0.5 on (Filippov)."""
    return {"start": 0.5, "time": 0.5, "after": 0.0, "rate_while_sliding": 0.0,
            "equivalent_weight_of_lower_side": 0.5}  # fmt: skip


def sliding_mode() -> dict[str, Any]:
    """x1' = x2, x2' = -U sign(x1 + x2): the line x1 + x2 = 0 is reached, then kept.

    On the way: x2 = -U t, x1 = 1 - U t^2/2, and s = 1 - U t - U t^2/2 = 0 at
    t = -1 + sqrt(1 + 2/U). On the line s' = x2 - U sign(s) points to it from both sides while
    |x2| < U; the mean right-hand side that keeps s' = 0 is x2' = -x2, so x1 decays as exp(-t).
    """
    u = 4.0
    t = -1 + np.sqrt(1 + 2 / u)
    x1, x2 = 1 - u * t * t / 2, -u * t
    agree(x1 + x2, 0)
    times = np.array([0.1, 0.2, 0.3, 0.5, 1.0, 2.0, 3.0])
    values = [
        [1 - u * s * s / 2, -u * s] if s < t else [x1 * np.exp(t - s), -x1 * np.exp(t - s)]
        for s in times
    ]
    return {"U": u, "start": [1.0, 0.0], "sliding_from": t, "at": [x1, x2],
            "times": times.tolist(), "values": np.array(values).tolist()}  # fmt: skip


def sliding_with_exit() -> dict[str, Any]:
    """x' = (0.4 - sin t) - sign(x)/2, x(0) = 0.2: sliding ends where the drive exceeds 1/2.

    x = 0 is kept while |0.4 - sin t| <= 1/2. Integrated with the three modes written out.
    """

    def drive(t: float) -> float:
        return 0.4 - float(np.sin(t))

    def above(t: float, _: Array) -> Array:
        return np.array([drive(t) - 0.5])

    def below(t: float, _: Array) -> Array:
        return np.array([drive(t) + 0.5])

    def at_zero(t: float, z: Array) -> tuple[str, Array, dict[str, Any]]:
        mode = "slide" if abs(drive(t)) < 0.5 else ("below" if drive(t) < 0 else "above")
        return mode, np.zeros(1), {"mode": mode}

    def leaves(name: str) -> Any:
        return lambda t, z: (name, np.zeros(1), {"mode": name})

    modes = {
        "above": Mode(above, [Guard(lambda t, z: z[0], -1, at_zero)]),
        "below": Mode(below, [Guard(lambda t, z: z[0], 1, at_zero)]),
        "slide": Mode(
            lambda t, z: np.zeros(1),
            [
                Guard(lambda t, z: drive(t) - 0.5, 1, leaves("above")),
                Guard(lambda t, z: drive(t) + 0.5, -1, leaves("below")),
            ],
        ),
    }
    times = np.linspace(0, 12, 49)
    values, events = integrate(modes, "above", [0.2], times, 0.01)
    return {"start": [0.2], "events": events, "times": times.tolist(), "values": values.tolist()}


def stick_slip() -> dict[str, Any]:
    """A mass on a moving belt, held by a spring; sticking friction Fs, slipping friction Fc.

    m x'' = -k x + F. Stuck: x' = vb until k x = Fs. Slipping (x' < vb): F = Fc; with
    u = x - Fc/k, w = sqrt(k/m): u = u0 cos wt + vb/w sin wt with u0 = (Fs - Fc)/k, x' returns to vb
    at u = -u0, after w t = 2 pi - 2 atan2(u0 w, vb). Compared with an integration.
    """
    m, k, fs, fc, belt = 1.0, 100.0, 12.0, 8.0, 0.2
    w, u0 = np.sqrt(k / m), (fs - fc) / k
    # u' = A w cos(w t + d), u = A sin(w t + d), u(0) = u0, u'(0) = vb: d in (0, pi/2).
    # u' = vb again at w t = 2 pi - 2 d, where u = -u0.
    delta = np.arctan2(u0 * w, belt)
    slip = (2 * np.pi - 2 * delta) / w
    stick = 2 * u0 / belt
    first = fs / k / belt  # from x = 0, stuck

    def run(_: float, z: Array) -> Array:
        return np.array([z[1], (fc - k * z[0]) / m])

    modes = {
        "stuck": Mode(
            lambda t, z: np.array([belt, 0.0]),
            [Guard(lambda t, z: k * z[0] - fs, 1, lambda t, z: ("slip", z, {"mode": "slip"}))],
        ),
        "slip": Mode(
            run,
            [Guard(lambda t, z: z[1] - belt, 1,
                   lambda t, z: ("stuck", np.array([z[0], belt]), {"mode": "stuck"}))],
        ),
    }  # fmt: skip
    times = np.linspace(0, 5, 101)
    values, events = integrate(modes, "stuck", [0.0, belt], times, 0.005)
    expected = [first]
    while expected[-1] < 5:
        expected.append(expected[-1] + (slip if len(expected) % 2 else stick))
    agree([e["time"] for e in events], expected[: len(events)])
    return {
        "parameters": {"m": m, "k": k, "Fs": fs, "Fc": fc, "belt": belt},
        "start": [0.0, belt],
        "variables": ["x", "v"],
        "first_slip": first,
        "slip_duration": slip,
        "stick_duration": stick,
        "x_at_slip": fs / k,
        "x_at_stick": (2 * fc - fs) / k,
        "events": events,
        "times": times.tolist(),
        "values": values.tolist(),
    }


def braked_block() -> dict[str, Any]:
    """A block with Coulomb friction slides to rest and stays, then is pushed off: closed form.

    m v' = F(t) - mu m g sign(v); F = 0 until t1, then rises as q (t - t1); stuck until F = mu m g.
    """
    m, mu, g, v0, q, t1 = 2.0, 0.3, 9.81, 1.5, 20.0, 1.0
    friction = mu * m * g
    stop = v0 * m / friction
    start = t1 + friction / q
    times = np.array([0.25, 0.45, 0.8, 1.2, 1.5, 2.0, 2.5])
    values = []
    for t in times:
        if t < stop:
            values.append([v0 * t - mu * g * t * t / 2, v0 - mu * g * t])
        else:
            d = max(t - start, 0.0)
            values.append([v0 * stop / 2 + q * d**3 / (6 * m), q * d * d / (2 * m)])
    return {
        "parameters": {"m": m, "mu": mu, "g": g, "v0": v0, "rate": q, "t1": t1},
        "stops": stop,
        "breaks_away": start,
        "distance_at_rest": v0 * stop / 2,
        "variables": ["x", "v"],
        "times": times.tolist(),
        "values": np.array(values).tolist(),
    }
