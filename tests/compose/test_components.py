# ruff: noqa: C408, PT009 - dict() is how modifiers are written; assert_ is ours
"""Components written in Python: equations, events, extension, models in models."""

from __future__ import annotations

import numpy as np
import pytest

import acausal as ac
from acausal.library import electrical as el
from acausal.library.mechanical import planar as pl


class Diode(ac.Component):
    """Diode with an exponential characteristic."""

    p = el.Pin()
    n = el.Pin()
    saturation = ac.Parameter(1e-12, unit="A")
    i = ac.Variable(unit="A")

    def equations(self):
        v = self.p.v - self.n.v
        yield self.i == self.saturation * (ac.exp(v / 0.025) - 1)
        yield self.p.i == self.i
        yield self.n.i == -self.i


def rectifier() -> ac.Model:
    model = ac.Model("rectifier", "half-wave rectifier")
    model.source = el.SineVoltage(V=1, f=1)
    model.d = Diode(saturation="1[pA]")
    model.r = el.Resistor(R=1000)
    model.ground = el.Ground()
    model.connect(model.source.p, model.d.p)
    model.connect(model.d.n, model.r.p)
    model.connect(model.r.n, model.source.n, model.ground.p)
    return model


def test_a_component_with_equations(same):
    result = same(rectifier())
    i = result["d.i"].values
    v = result["d.p.v"].values - result["d.n.v"].values
    assert np.allclose(i, 1e-12 * (np.exp(v / 0.025) - 1), rtol=1e-4, atol=1e-9)
    assert i.max() > 3e-4


def test_the_example_of_the_design(same):
    circuit = ac.Model("rlc")
    circuit.source = el.SineVoltage(V=10, f=50)
    circuit.r = el.Resistor(R=100)
    circuit.c = el.Capacitor(C=1e-6)
    circuit.ground = el.Ground()
    circuit.connect(circuit.source.p, circuit.r.p)
    circuit.connect(circuit.r.n, circuit.c.p)
    circuit.connect(circuit.c.n, circuit.source.n, circuit.ground.p)
    result = circuit.simulate(stop_time=0.1)
    w, tau = 2 * np.pi * 50, 1e-4
    t = result["c.v"].time
    settled = 10 / np.hypot(1, w * tau) * np.sin(w * t - np.arctan(w * tau))
    late = t > 0.01
    assert np.allclose(result["c.v"].values[late], settled[late], atol=1e-4)
    same(circuit, 0.1)


def test_a_chain_of_pendulums_in_three_lines(same):
    chain = ac.Model("chain")
    chain.link = pl.Pendulum(length=0.5, mass=1, phi=dict(start=0.3), shape=6)
    chain.connect(chain.link[:-1].tip, chain.link[1:].pivot)
    # What they hang on; the world is the one that the links ask for, so it is inner.
    chain.anchor = pl.Anchor()
    chain.world = pl.PlanarWorld()
    chain.connect(chain.anchor.hinge, chain.link[0].pivot)
    assert "inner mechanical.planar.PlanarWorld world" in chain.to_acm()
    result = same(chain, 0.2)
    energy = sum(
        result[f"link[{k}].E_kin"].values + result[f"link[{k}].E_pot"].values for k in range(1, 7)
    )
    assert np.ptp(energy) < 1e-4 * abs(energy[0])


def test_inner_can_be_said_and_forbidden():
    model = ac.Model("m")
    model.p = pl.Pendulum()
    model.a = pl.Anchor()
    model.connect(model.a.hinge, model.p.pivot)
    model.world = pl.PlanarWorld(inner=False)
    with pytest.raises(ac.AcausalError) as caught:
        model.compile()
    assert caught.value.diagnostics[0].code == "N118"
    assert "model.world" not in caught.value.diagnostics[0].help
    assert "m.world = ...PlanarWorld()" in caught.value.diagnostics[0].help


def bouncing() -> ac.Model:
    ball = ac.Model("ball")
    ball.e = ac.Parameter(0.8)
    ball.h = ac.Variable(unit="m", start=1, fixed=True)
    ball.v = ac.Variable(unit="m/s", start=0, fixed=True)
    ball.bounces = ac.Variable(type=int, start=0, fixed=True)
    ball.equation(ac.der(ball.h) == ball.v, ac.der(ball.v) == "-9.81[m/s2]")
    ball.equation(
        ac.when(
            ball.h < 0,
            {ball.bounces: ac.pre(ball.bounces) + 1},
            ac.reinit(ball.v, -ball.e * ac.pre(ball.v)),
        )
    )
    return ball


def test_events(same):
    result = same(bouncing(), 1.5)
    first = np.sqrt(2 / 9.81)
    second = first + 2 * 0.8 * first
    t, n = result["bounces"].time, result["bounces"].values
    assert n[t < first - 1e-3].max() == 0
    assert n[(t > first + 1e-3) & (t < second - 1e-3)].min() == 1
    assert n[-1] == 2


def test_sampling_elsewhen_conditions_and_choices(same):
    model = ac.Model("sampled")
    model.x = ac.Discrete(start=0, fixed=True)
    model.on = ac.Variable(type=bool, start=False, fixed=True)
    model.y = ac.Variable()
    model.z = ac.Variable()
    t = ac.time
    model.equation(ac.when(ac.sample(0.1, 0.1), model.x == ac.pre(model.x) + 1))
    model.equation(
        ac.when((t > 0.35) & ~(t > 5), {model.on: True}).elsewhen(t > 0.75, {model.on: False})
    )
    model.equation(model.y == ac.where(model.on, 2.0, ac.where(t > 0.9, 3.0, 1.0)))
    model.equation(ac.if_then(model.on, model.z == 1).otherwise(model.z == -model.x))
    model.equation(ac.assert_(model.x < 100, "too many"))
    result = same(model)
    t, y, x = result["y"].time, result["y"].values, result["x"].values
    assert set(y[(t > 0.36) & (t < 0.74)]) == {2.0}
    assert y[-1] == 3.0
    assert y[t < 0.3].max() == 1.0
    assert x[-1] in (9, 10)


def test_a_library_component_is_extended(same):
    class Aging(el.Resistor, alpha=0):
        """Resistor that grows with time."""

        rate = ac.Parameter(0.5, unit="1/s")
        T_ref = 350
        lost = ac.Variable(unit="J", start=0, fixed=True)

        def equations(self):
            yield ac.der(self.lost) == self.LossPower * (1 + self.rate * ac.time)

    model = ac.Model("aged")
    model.s = el.ConstantVoltage(V=2)
    model.r = Aging(R=4, rate=1)
    model.g = el.Ground()
    model.connect(model.s.p, model.r.p)
    model.connect(model.s.n, model.r.n, model.g.p)
    text = model.to_acm()
    assert "extends electrical.Resistor(T_ref = 350, alpha = 0)" in text
    result = same(model)
    assert result["r.lost"].values[-1] == pytest.approx(1.5, rel=1e-6)


def test_python_classes_inherit_as_python_does(same):
    class Base(ac.Component):
        k = ac.Parameter(2.0)
        x = ac.Variable()

        def equations(self):
            return [self.x == self.k * ac.time]

    class Replaced(Base):
        k = 5

        def equations(self):
            yield self.x == self.k

    class Added(Base):
        y = ac.Variable()

        def equations(self):
            yield from super().equations()
            yield self.y == self.x**2

    model = ac.Model("m")
    model.a, model.b, model.c, model.d = Base(), Replaced(), Added(k=3), Replaced(k=7)
    result = same(model)
    last = {n: result[n].values[-1] for n in ("a.x", "b.x", "c.y", "d.x")}
    assert last == pytest.approx({"a.x": 2, "b.x": 5, "c.y": 9, "d.x": 7})


class Lowpass(ac.Model):
    """RC section with cuts of its own."""

    def build(self, R=1.0, C=1e-3, load=None):
        self.p = el.Pin()
        self.n = el.Pin()
        self.out = el.Pin()
        self.R = ac.Parameter(R, unit="Ohm")
        self.r = el.Resistor(R=self.R)
        self.c = el.Capacitor(C=C, v=dict(start=0, fixed=True))
        self.connect(self.p, self.r.p)
        self.connect(self.r.n, self.c.p, self.out)
        self.connect(self.c.n, self.n)
        if load is not None:
            self.load = el.Resistor(R=load)
            self.connect(self.load.p, self.out)
            self.connect(self.load.n, self.n)


def lowpass(R):
    section = ac.Model("section")
    section.p, section.n, section.out = el.Pin(), el.Pin(), el.Pin()
    section.r = el.Resistor(R=R)
    section.c = el.Capacitor(C=1e-3, v=dict(start=0, fixed=True))
    section.connect(section.p, section.r.p)
    section.connect(section.r.n, section.c.p, section.out)
    section.connect(section.c.n, section.n)
    return section


def test_models_in_models(same):
    model = ac.Model("filters")
    model.s = el.ConstantVoltage(V=1)
    model.g = el.Ground()
    model.connect(model.s.n, model.g.p)
    model.one = Lowpass(R=1)
    model.two = Lowpass(R=2)
    model.loaded = Lowpass(R=1, load=3)
    model.many = Lowpass(R=2, shape=3)
    model.made = lowpass(4)
    for part in (model.one, model.two, model.loaded, model.made):
        model.connect(part.p, model.s.p)
        model.connect(part.n, model.g.p)
    model.connect(model.many[0].p, model.s.p)
    model.connect(model.many[:-1].out, model.many[1:].p)
    for cell in model.many:
        model.connect(cell.n, model.g.p)
    model.sum_ = ac.Variable(ac.sum(model.many.c.v), unit="V")
    model.first = ac.Variable(model.one.c.v, unit="V")
    text = model.to_acm()
    # Sections that differ in a parameter only are one class.
    assert text.count("model Lowpass") == 2
    assert text.count("model section") == 1
    result = same(model, 0.01)
    t = result["one.c.v"].time
    assert np.allclose(result["one.c.v"].values, 1 - np.exp(-t / 1e-3), atol=1e-5)
    assert np.allclose(result["two.c.v"].values, 1 - np.exp(-t / 2e-3), atol=1e-5)
    assert np.allclose(result["made.c.v"].values, 1 - np.exp(-t / 4e-3), atol=1e-5)
    assert result["loaded.c.v"].values[-1] == pytest.approx(0.75, abs=1e-4)
    assert np.allclose(
        result["sum_"].values, sum(result[f"many[{k}].c.v"].values for k in (1, 2, 3))
    )


def test_a_connector_of_ones_own_and_array_equations(same):
    class Flange(ac.Connector):
        x = ac.Across("m", "position", shape=2)
        f = ac.Through("N", "force", shape=2)

    class Mass(ac.Component):
        a = Flange()
        m = ac.Parameter(1.0, unit="kg")
        v = ac.Variable(unit="m/s", shape=2, start=np.array([0.0, 1.0]), fixed=True)
        x = ac.Variable(unit="m", shape=2, start=[1, 0], fixed=True)

        def equations(self):
            yield self.a.x == self.x
            yield ac.der(self.x) == self.v
            yield self.m * ac.der(self.v) == self.a.f

    class Spring(ac.Component):
        n = ac.Parameter(2, type=int)
        c = ac.Parameter([1.0, 1.0], unit="N/m", shape=n)
        a = Flange()

        def equations(self):
            yield self.a.f == self.c * self.a.x

    model = ac.Model("orbit")
    model.mass = Mass()
    model.spring = Spring()
    model.connect(model.mass.a, model.spring.a)
    result = same(model)
    t = result["mass.x[1]"].time
    assert np.allclose(result["mass.x[1]"].values, np.cos(t), atol=1e-4)
    assert np.allclose(result["mass.x[2]"].values, np.sin(t), atol=1e-4)


def test_initial_equations_loops_and_sums(same):
    class Row(ac.Component):
        x = ac.Variable(shape=4)
        total = ac.Variable()

        def equations(self):
            for k, x in enumerate(self.x):
                yield ac.der(x) == -(k + 1) * x
            yield self.total == sum(self.x)

        def initial_equations(self):
            yield self.x == [1, 2, 3, 4]

    model = ac.Model("row")
    model.row = Row()
    model.q = ac.Variable()
    model.equation(ac.der(model.q) == 1)
    model.initial(model.q == 2 * model.row.total)
    result = same(model)
    assert result["q"].values[0] == pytest.approx(20)
    expected = sum(k * np.exp(-k) for k in range(1, 5))
    assert result["row.total"].values[-1] == pytest.approx(expected, rel=1e-4)


def test_classes_of_a_file(tmp_path, same):
    path = tmp_path / "parts.acm"
    path.write_text(
        "import electrical.*;\npartial model Two\n  Pin p, n;\nend Two;\n"
        'model Shunt "load"\n  extends Two;\n  parameter Real G(unit = "S") = 2[mS];\nequation\n'
        "  p.i + n.i = 0;\n  p.i = G*(p.v - n.v);\nend Shunt;\n"
    )
    parts = ac.load(path)
    assert dir(parts) == ["Shunt", "Two"]
    model = ac.Model("loaded")
    model.s = el.ConstantVoltage(V=5)
    model.load = parts.Shunt(G="1[S]")
    model.g = el.Ground()
    model.connect(model.s.p, model.load.p)
    model.connect(model.s.n, model.load.n, model.g.p)
    assert "model Shunt" in model.to_acm()
    assert same(model)["load.p.i"].values[-1] == pytest.approx(5)


def test_a_copy_can_be_changed():
    model = rectifier()
    model.compile()
    other = model.copy()
    other.extra = el.Resistor(R=1000)
    other.connect(other.extra.p, other.r.p)
    other.connect(other.extra.n, other.r.n)
    one, two = (m.simulate(stop_time=1)["source.i"].values.min() for m in (model, other))
    assert two < 1.5 * one < 0
    assert not hasattr(model, "extra")
    assert model.compile() is model.compile()


def test_experiment_and_parameters_of_a_compilation():
    model = rectifier()
    model.experiment(stop_time=0.25, tolerance=1e-8, interval=0.05)
    result = model.simulate()
    assert len(result["r.v"].time) == 6 or result["r.v"].time[-1] == 0.25
    assert "experiment(StopTime = 0.25" in model.to_acm()
    double = model.simulate(parameters={"r.R": "2[kOhm]"})
    assert double["r.i"].values[-1] < result["r.i"].values[-1]


class Closed(ac.Model):
    """Everything in the class, connections with the equations."""

    v = el.ConstantVoltage(V=2)
    r = el.Resistor(R=4)
    g = el.Ground()

    def equations(self):
        self.extra = ac.Variable(self.r.v)
        self.connect(self.v.p, self.r.p)
        self.connect(self.v.n, self.r.n, self.g.p)


def test_writing_a_model_does_not_change_it(same):
    model = Closed()
    text = model.to_acm()
    assert model.to_acm() == text
    assert same(model)["extra"].values[-1] == 2
    assert model.to_acm() == text
    whole = ac.Model("whole")
    whole.one, whole.two = Closed(), Closed()
    assert whole.to_acm().count("model Closed") == 1
    assert same(whole)["two.r.i"].values[-1] == 0.5


def test_a_constructor_of_ones_own(same):
    class Load(ac.Model):
        def __init__(self, R):
            super().__init__("load")
            self.count = 3
            self.p, self.n = el.Pin(), el.Pin()
            self.r = el.Resistor(R=R)
            self.connect(self.p, self.r.p)
            self.connect(self.n, self.r.n)

    model = ac.Model("m")
    model.s, model.g = el.ConstantVoltage(V=1), el.Ground()
    model.a, model.b = Load(5), Load(4)
    for part in (model.a, model.b):
        model.connect(part.p, model.s.p)
        model.connect(part.n, model.s.n, model.g.p)
    assert model.a.count == 3
    assert same(model)["s.i"].values[-1] == pytest.approx(-0.45)
