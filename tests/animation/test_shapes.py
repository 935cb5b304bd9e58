"""Shapes of annotations and of Python, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import acausal as ac
from acausal.animation.animation import Animation, animate
from acausal.diagnostics import AcausalError

ORBIT = """
model Orbit "a point on a circle"
  parameter Real r = 2;
  parameter Real ends[2, 2] = [0, 0; 3, 1];
  Real x; Real y; Real z[2];
equation
  x = r*cos(time);
  y = r*sin(time);
  z = {x, 2*y};
  %s
end Orbit;
"""


def orbit(shapes="", stop=1.0):
    text = f"annotation(Animation({shapes}));" if shapes else ""
    return ac.compile_text(ORBIT % text).simulate(stop_time=stop, points=2001)


def refused(code, shapes):
    with pytest.raises(AcausalError) as error:
        Animation(orbit(f"shapes = {{{shapes}}}")).scene()
    assert error.value.diagnostics[0].code == code
    return error.value.diagnostics[0]


def channels(shapes):
    scene = Animation(orbit(f"shapes = {{{shapes}}}")).scene()
    return scene.times, scene.sprites[0].channels


@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ("{x, y}", lambda t: (2 * np.cos(t), 2 * np.sin(t))),
        ("z", lambda t: (2 * np.cos(t), 4 * np.sin(t))),
        ("{x + 1, -y}", lambda t: (2 * np.cos(t) + 1, -2 * np.sin(t))),
        ("{x, y} + {1, r}", lambda t: (2 * np.cos(t) + 1, 2 * np.sin(t) + 2)),
        ("{r*sin(time)^2, sqrt(abs(x))}", lambda t: (2 * np.sin(t) ** 2, np.sqrt(2 * np.cos(t)))),
        ("{if y > 1 then 5 else 0, max(x, 1.9)}",
         lambda t: (np.where(2 * np.sin(t) > 1, 5, 0), np.maximum(2 * np.cos(t), 1.9))),
        ("{{x, y}*{y, x}, 10[cm]}", lambda t: (8 * np.sin(t) * np.cos(t), 0.1 + 0 * t)),
        ("{ends[2, 1] + time, constants.pi}", lambda t: (3 + t, np.pi + 0 * t)),
    ],
)  # fmt: skip
def test_expressions_of_points(point, expected):
    t, (x, y, _) = channels(f"Circle(at = {point})")
    for value, known in zip((x, y), expected(t), strict=True):
        np.testing.assert_allclose(np.broadcast_to(value, t.shape), known, atol=1e-5)


def test_shapes_are_repeated():
    scene = Animation(
        orbit("shapes = {Circle(at = {ends[k, 1], ends[k, 2]}) for k in 1:2}")
    ).scene()
    assert [[float(c[0]) for c in s.channels[:2]] for s in scene.sprites] == [[0, 0], [3, 1]]


def test_offset_turns_with_its_frame():
    result = ac.compile_text("""
import mechanical.planar.*;
model Turning
  inner PlanarWorld world;
  Fixed base;
  Revolute joint(phi(start = 0, fixed = true), w(start = 1, fixed = true));
  Body body(m = 1, I = 1);
equation
  connect(base.frame_a, joint.frame_a);
  connect(joint.frame_b, body.frame_a);
  annotation(Animation(components = false,
    shapes = {Circle(at = body.frame_a, offset = {0.5, 0})}));
end Turning;
""").simulate(stop_time=3, points=3001)
    scene = Animation(result).scene()
    (one,) = scene.sprites
    np.testing.assert_allclose(one.channels[0], 0.5 * np.cos(scene.times), atol=1e-5)
    np.testing.assert_allclose(one.channels[1], 0.5 * np.sin(scene.times), atol=1e-5)


def test_inherited_shapes_and_inner_components():
    text = """
model Base
  Real a = time;
  annotation(Animation(shapes = {Circle(at = {a, 0})}));
end Base;
model More
  extends Base;
  annotation(Animation(shapes = {Box(at = {a, 1})}));
end More;
model Own
  extends Base;
  annotation(Animation(inherit = false, shapes = {Box(at = {a, 1})}));
end Own;
model Whole
  More more; Own own[2];
end Whole;
model Hiding
  More more;
  annotation(Animation(components = false, shapes = {Circle(at = {more.a, 5})}));
end Hiding;
"""

    def names(model):
        scene = Animation(ac.compile_text(text, model).simulate(stop_time=1)).scene()
        return sorted(s.name for s in scene.sprites)

    assert names("More") == ["", ""]
    assert names("Whole") == ["more", "more", "own[1]", "own[2]"]
    assert names("Hiding") == [""]


def test_arrows_are_scaled_and_hidden_where_short():
    arrow = "Arrow(at = {0, 0}, vector = {x, 0}, scale = 0.5, width = 0.1)"
    scene = Animation(orbit(f"shapes = {{{arrow}}}", stop=1.6)).scene()
    (arrow,) = scene.sprites
    np.testing.assert_allclose(arrow.channels[2], np.cos(scene.times), atol=1e-5)
    assert arrow.visible[0] == 1 and arrow.visible[-1] == 0


def test_own_shapes_in_python():
    result = orbit()
    animation = (
        Animation(result)
        .rod((0, 0), ("x", "y"), width=0.1, color="red")
        .circle(("x", "y"), radius=0.2)
        .trail(("x", "y"))
        .text((0, 1), "centre")
        .shape("Polygon", points=((0, 0), (1, 0), (0, 1)), angle="time")
        .arrow(("x", "y"), ("-y", "x"), color=[10, 20, 30])
    )
    scene = animation.scene()
    kinds = [s.kind for s in scene.sprites]
    assert kinds == ["trail", "stretched", "placed", "placed", "stretched", "text"]
    assert scene.sprites[1].geometry[0].fill == "#c8504f"
    assert scene.sprites[4].geometry[0].fill == "#0a141e"


@pytest.mark.parametrize(
    ("shapes", "code", "words"),
    [
        ("Cirle(at = {x, y})", "D111", "Circle"),
        ("x", "D111", "shapes = {"),
        ("Circle(radius = 1)", "D112", "at"),
        ("Circle(at = {x, y}, radus = 1)", "D112", "radius"),
        ("Circle({x, y})", "D112", "at = "),
        ("Circle(at = {x, yy})", "D113", "yy"),
        ("Circle(at = {x, y, x, y})", "D113", "{x, y}"),
        ('Circle(at = {x, y}, color = "bleu")', "D113", "blue"),
        ("Circle(at = {x, y}, radius = {1, 2})", "D113", "number"),
        ("Circle(at = {x, tann(y)})", "D113", "tann"),
        ("Circle(at = {x, y}) for k in 1:2:3", "D113", "range"),
        ("Box(at = {x, y, 0}), Car(at = {x, y})", "D113", "space"),
    ],
)
def test_mistakes_are_named(shapes, code, words):
    diagnostic = refused(code, shapes)
    assert words in f"{diagnostic.message} {diagnostic.help} {diagnostic.notes}"
    assert diagnostic.span is not None


def code_of(call):
    with pytest.raises(AcausalError) as error:
        call()
    return error.value.diagnostics[0].code


def test_what_cannot_be_animated(tmp_path):
    result = orbit()
    assert code_of(lambda: Animation(result).scene()) == "D114"
    assert code_of(lambda: animate(result, tmp_path / "a.html")) == "D114"
    assert code_of(lambda: Animation(result).circle(("x", "y")).save(tmp_path / "a.avi")) == "F201"
    assert (
        code_of(lambda: Animation(result).circle(("x", "y")).save(tmp_path / "no/a.gif")) == "F202"
    )
    assert code_of(lambda: Animation(result, speed=0)) == "D116"
    assert (
        code_of(lambda: Animation(result).circle(("x", "y")).save(tmp_path / "a.gif", fps=-1))
        == "D116"
    )
    assert (
        code_of(lambda: Animation(result).circle(("x", "y")).save(tmp_path / "a.gif", width=3))
        == "D116"
    )
    assert code_of(lambda: Animation(result).shape("Cirlce", at=(0, 0))) == "D111"
    assert list(tmp_path.iterdir()) == []


def test_results_of_files_say_that_they_lack_shapes(tmp_path):
    compiled = ac.compile_text(ORBIT % "annotation(Animation(shapes = {Circle(at = {x, y})}));")
    compiled.simulate().write(tmp_path / "orbit.csv")
    read = ac.read_result(tmp_path / "orbit.csv")
    assert code_of(lambda: read.animate(tmp_path / "a.html")) == "D115"
    assert len(read.animate(model=compiled).scene().sprites) == 1
    assert len(Animation(read).circle(("x", "y")).scene().sprites) == 1
