"""Overdetermined connectors: who sets an orientation, and where loops are taken apart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_text
from acausal.connections.spanning import instantiate_rooted, spanning_forest
from acausal.diagnostics import AcausalError
from acausal.flattening.flatten import flatten
from acausal.modeling.load import choose_model, load_text

FRAMES = (Path(__file__).parent / "frames.acm").read_text()


def simulated(text: str, stop: float, **options: Any) -> Any:
    return compile_text(FRAMES + text).simulate(stop_time=stop, tolerance=1e-9, **options)


def forest_of(text: str) -> tuple[Any, Any]:
    classes, _ = load_text(FRAMES + text)
    templates, left = instantiate_rooted(choose_model(classes, None, "the text"), {})
    flattened = flatten(templates, left)
    return flattened, spanning_forest(flattened.numbering, flattened.junctions)


def vector(result: Any, name: str) -> np.ndarray:
    return np.stack([result[f"{name}[{k}]"].values for k in (1, 2, 3)], axis=1)


def matrix(result: Any, name: str) -> np.ndarray:
    rows = [[result[f"{name}[{i},{k}]"].values for k in (1, 2, 3)] for i in (1, 2, 3)]
    return np.moveaxis(np.array(rows), 2, 0)


def test_a_tree_has_no_broken_connection_and_its_body_is_no_root() -> None:
    model = """
model Tree
  World world;
  Revolute j(phi(start = 1, fixed = true), w(start = 0, fixed = true));
  FreeBody body(r_CM = {0, -1, 0}, I = zeros(3, 3));
equation
  connect(world.frame_b, j.frame_a);
  connect(j.frame_b, body.frame_a);
end Tree;
"""
    _, forest = forest_of(model)
    assert len(forest.broken) == 0
    assert forest.is_root.sum() == 1
    result = simulated(model, 2.0)
    energy = 0.5 * result["j.w"].values ** 2 - 9.81 * np.cos(result["j.phi"].values)
    assert energy == pytest.approx(-9.81 * np.cos(1.0), abs=1e-6)


def test_a_free_body_turns_by_itself() -> None:
    # Euler's equations of a body without torques: energy and angular momentum in space stay.
    result = simulated(
        """
model Free
  parameter Real J[3, 3] = diagonal({1, 2, 3});
  FreeBody b(I = J, r_CM = {0, 0, 0},
             v_0(each start = 0, each fixed = true), frame_a.r_0(each start = 0, each fixed = true),
             w_a(start = {0.1, 3, 0}, each fixed = true));
end Free;
""",
        20.0,
    )
    inertia, speed = np.diag([1.0, 2.0, 3.0]), vector(result, "b.w_a")
    energy = np.einsum("ti,ij,tj->t", speed, inertia, speed)
    assert energy == pytest.approx(18.01, rel=1e-6)
    momentum = np.einsum(
        "tji,tj->ti", matrix(result, "b.frame_a.R.T"), np.einsum("ij,tj->ti", inertia, speed)
    )
    assert momentum == pytest.approx(np.broadcast_to(momentum[0], momentum.shape), abs=1e-5)
    # The middle axis is unstable: the body turns over.
    assert speed[:, 1].min() < -2.9


def test_one_of_two_bodies_joined_rigidly_is_the_root() -> None:
    model = """
model Pair
  FreeBody b(r_CM = zeros(3)), c(r_CM = zeros(3));
  FixedTranslation t(r = {2, 0, 0});
equation
  connect(b.frame_a, t.frame_a);
  connect(t.frame_b, c.frame_a);
end Pair;
"""
    flattened, forest = forest_of(model)
    assert forest.is_root.sum() == 1
    answers = [t.answers for t in (g.template for g in flattened.numbering.groups) if t.answers]
    assert sorted(a["Connections.isRoot(frame_a.R)"] for a in answers) == [False, True]


LOOP = """
model Loop "a chain with six degrees of freedom follows the tip of a crank"
  World world;
  Revolute crank(phi(start = 0.2, fixed = true, stateSelect = StateSelect.always),
                 w(start = 0, fixed = true, stateSelect = StateSelect.always), n = {0, 0, 1});
  FixedTranslation arm(r = {1, 0, 0});
  Prismatic px(n = {1, 0, 0}), py(n = {0, 1, 0}), pz(n = {0, 0, 1});
  Revolute rx(n = {1, 0, 0}), ry(n = {0, 1, 0}), rz(n = {0, 0, 1});
  Body body(m = 2, r_CM = {0, 0, 0}, I = zeros(3, 3));
equation
  connect(world.frame_b, crank.frame_a, px.frame_a);
  connect(crank.frame_b, arm.frame_a);
  connect(px.frame_b, py.frame_a);
  connect(py.frame_b, pz.frame_a);
  connect(pz.frame_b, rx.frame_a);
  connect(rx.frame_b, ry.frame_a);
  connect(ry.frame_b, rz.frame_a);
  connect(rz.frame_b, body.frame_a);
  connect(arm.frame_b, body.frame_a);
end Loop;
"""


def test_a_loop_is_taken_apart_once_and_closes() -> None:
    _, forest = forest_of(LOOP)
    assert len(forest.broken) == 1
    result = simulated(LOOP, 3.0)
    angle = result["crank.phi"].values
    assert result["px.s"].values == pytest.approx(np.cos(angle), abs=1e-8)
    assert result["py.s"].values == pytest.approx(np.sin(angle), abs=1e-8)
    assert result["rz.phi"].values == pytest.approx(angle, abs=1e-7)
    for name in ("pz.s", "rx.phi", "ry.phi"):
        assert result[name].values == pytest.approx(0.0, abs=1e-8)
    energy = result["crank.w"].values ** 2 + 2 * 9.81 * np.sin(angle)
    assert energy == pytest.approx(2 * 9.81 * np.sin(0.2), abs=1e-5)


def test_a_connection_that_is_stated_twice_is_no_loop() -> None:
    _, forest = forest_of("""
model Twice
  World world;
  Body body;
equation
  connect(world.frame_b, body.frame_a);
  connect(body.frame_a, world.frame_b);
end Twice;
""")
    assert len(forest.broken) == 0


def test_rooted_tells_on_which_side_the_root_is() -> None:
    model = """
model Either
  Frame frame_a, frame_b;
  parameter Boolean forward = Connections.rooted(frame_a.R);
equation
  Connections.branch(frame_a.R, frame_b.R);
  frame_a.r_0 = frame_b.r_0;
  frame_a.R = frame_b.R;
  zeros(3) = frame_a.f + frame_b.f;
  zeros(3) = frame_a.t + frame_b.t;
end Either;

model Sides
  World world;
  Either towards, away;
  Body b, c;
equation
  connect(world.frame_b, away.frame_a, towards.frame_b);
  connect(away.frame_b, b.frame_a);
  connect(towards.frame_a, c.frame_a);
end Sides;
"""
    flattened, _ = forest_of(model)
    children = flattened.numbering.groups[-1].template.children
    forward = {
        n: children[n].template.structural["forward"].expr.value for n in ("towards", "away")
    }
    assert forward == {"towards": 0.0, "away": 1.0}


def test_a_thousand_bodies_of_an_array_are_roots_of_their_own() -> None:
    _, forest = forest_of("""
model Swarm
  FreeBody b[1000](each r_CM = zeros(3));
end Swarm;
""")
    assert forest.is_root.sum() == 1000


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("World a, b; equation Connections.branch(a.frame_b.R, b.frame_b.R);", "C107"),
        ("Body b; FixedTranslation t; equation connect(b.frame_a, t.frame_a);", "C108"),
        ("FreeBody b[2]; FixedTranslation t; equation connect(b[1].frame_a, t.frame_a); "
         "connect(b[2].frame_a, t.frame_b);", "C109"),
        ("World w; Body b; equation connect(w.frame_b, b.frame_a); "
         "Connections.branch(w.frame_b.r_0, b.frame_a.r_0);", "C106"),
        ("World w; equation Connections.leaf(w.frame_b.R);", "C106"),
        ("World w; Real x; equation x = if Connections.isRoot(3) then 1 else 2;", "C106"),
        ("World w; Body b; equation connect(w.frame_b, b.frame_a); "
         "if time > 1 then Connections.root(b.frame_a.R); end if;", "C105"),
    ],
)  # fmt: skip
def test_mistakes_are_explained(text: str, code: str) -> None:
    with pytest.raises(AcausalError) as error:
        forest_of(f"model Wrong {text} end Wrong;")
    assert error.value.diagnostics[0].code == code
    assert error.value.diagnostics[0].help
