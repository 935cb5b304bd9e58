"""State machines of steps and transitions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.library.blocks_runs import jumps, run, values

S = "blocks.state_graph"


def test_light_goes_round() -> None:
    result = run(
        f"""
  {S}.InitialStep red;
  {S}.Step green, yellow;
  {S}.Transition a(enableTimer = true, waitTime = 3);
  {S}.Transition b(enableTimer = true, waitTime = 2);
  {S}.Transition c(enableTimer = true, waitTime = 0.5);
equation
  connect(red.outPort[1], a.inPort);
  connect(a.outPort, green.inPort[1]);
  connect(green.outPort[1], b.inPort);
  connect(b.outPort, yellow.inPort[1]);
  connect(yellow.outPort[1], c.inPort);
  connect(c.outPort, red.inPort[1]);
""",
        stop_time=13,
    )
    assert jumps(result, "red.active") == [(3, 0), (5.5, 1), (8.5, 0), (11, 1)]
    assert jumps(result, "green.active") == [(3, 1), (5, 0), (8.5, 1), (10.5, 0)]
    assert jumps(result, "yellow.active") == [(5, 1), (5.5, 0), (10.5, 1), (11, 0)]
    total = sum(values(result, f"{x}.active") for x in ("red", "green", "yellow"))
    assert set(total) == {1.0}


def test_tank_is_filled_and_emptied_by_its_level() -> None:
    # filling: h' = 2, emptying: h' = -h
    result = run(
        f"""
  Real h(start = 0, fixed = true);
  {S}.InitialStep fill;
  {S}.Step empty;
  {S}.Transition full(condition = h > 1);
  {S}.Transition low(condition = h < 0.25);
equation
  der(h) = if fill.active then 2 else -h;
  connect(fill.outPort[1], full.inPort);
  connect(full.outPort, empty.inPort[1]);
  connect(empty.outPort[1], low.inPort);
  connect(low.outPort, fill.inPort[1]);
""",
        stop_time=8,
        tolerance=1e-10,
    )
    expected, time = [], 0.5
    while time < 8:
        expected.append(time)
        time += np.log(4) if len(expected) % 2 else 0.375
    assert [t for t, _ in jumps(result, "empty.active")] == pytest.approx(expected, abs=1e-7)
    assert len(expected) >= 8


def test_several_transitions_at_one_instant() -> None:
    # without conditions the mark runs through at the start, to where it has to wait
    result = run(
        f"""
  {S}.InitialStep a;
  {S}.Step b, c;
  {S}.Transition ab, bc(condition = time > 1), ca;
  Integer passed(start = 0, fixed = true);
equation
  connect(a.outPort[1], ab.inPort);
  connect(ab.outPort, b.inPort[1]);
  connect(b.outPort[1], bc.inPort);
  connect(bc.outPort, c.inPort[1]);
  connect(c.outPort[1], ca.inPort);
  connect(ca.outPort, a.inPort[1]);
  when c.active then
    passed = pre(passed) + 1;
  end when;
""",
        stop_time=0.9,
    )
    assert set(values(result, "b.active")) == {1.0}
    assert set(values(result, "passed")) == {0.0}


def test_first_branch_that_can_is_taken() -> None:
    result = run(
        f"""
  {S}.InitialStep start(nOut = 2);
  {S}.Step left, right;
  {S}.Transition one(condition = time >= 2), two(condition = time >= 2);
equation
  connect(start.outPort[1], one.inPort);
  connect(start.outPort[2], two.inPort);
  connect(one.outPort, left.inPort[1]);
  connect(two.outPort, right.inPort[1]);
  left.outPort[1].reset = false;
  right.outPort[1].reset = false;
  start.inPort[1].set = false;
""",
        stop_time=3,
    )
    assert jumps(result, "left.active") == [(2, 1)]
    assert set(values(result, "right.active")) == {0.0}
    assert jumps(result, "start.active") == [(2, 0)]


def test_alternative_branches() -> None:
    result = run(
        f"""
  {S}.InitialStep idle(nIn = 1);
  {S}.Alternative choice(nBranches = 2);
  {S}.Step slow, fast, done;
  {S}.Transition take_slow(condition = time > 5), take_fast(condition = time > 1);
  {S}.Transition end_slow(enableTimer = true, waitTime = 3);
  {S}.Transition end_fast(enableTimer = true, waitTime = 1);
  {S}.Transition again(enableTimer = true, waitTime = 10);
equation
  connect(idle.outPort[1], choice.inPort);
  connect(choice.split[1], take_slow.inPort);
  connect(choice.split[2], take_fast.inPort);
  connect(take_slow.outPort, slow.inPort[1]);
  connect(take_fast.outPort, fast.inPort[1]);
  connect(slow.outPort[1], end_slow.inPort);
  connect(fast.outPort[1], end_fast.inPort);
  connect(end_slow.outPort, choice.join[1]);
  connect(end_fast.outPort, choice.join[2]);
  connect(choice.outPort, done.inPort[1]);
  connect(done.outPort[1], again.inPort);
  connect(again.outPort, idle.inPort[1]);
""",
        stop_time=20,
    )
    assert jumps(result, "fast.active") == [(pytest.approx(1), 1), (pytest.approx(2), 0)]
    assert jumps(result, "done.active") == [
        (pytest.approx(2), 1), (pytest.approx(12), 0), (pytest.approx(15), 1)
    ]  # fmt: skip
    # the second time both could be taken
    assert jumps(result, "slow.active") == [(pytest.approx(12), 1), (pytest.approx(15), 0)]


def test_parallel_branches_wait_for_each_other() -> None:
    result = run(
        f"""
  {S}.InitialStep start;
  {S}.Step a, b, b2, done(nOut = 0);
  {S}.Parallel both(nBranches = 2);
  {S}.Transition go(enableTimer = true, waitTime = 1), step(enableTimer = true, waitTime = 3), join;
equation
  connect(start.outPort[1], go.inPort);
  connect(go.outPort, both.inPort);
  connect(both.split[1], a.inPort[1]);
  connect(both.split[2], b.inPort[1]);
  connect(b.outPort[1], step.inPort);
  connect(step.outPort, b2.inPort[1]);
  connect(a.outPort[1], both.join[1]);
  connect(b2.outPort[1], both.join[2]);
  connect(both.outPort, join.inPort);
  connect(join.outPort, done.inPort[1]);
  start.inPort[1].set = false;
""",
        stop_time=6,
    )
    assert jumps(result, "a.active") == [(1, 1), (4, 0)]
    assert jumps(result, "b.active") == [(1, 1), (4, 0)]
    assert jumps(result, "done.active") == [(4, 1)]
    assert values(result, "b2.active")[-1] == 0


def test_condition_from_a_signal() -> None:
    result = run(
        f"""
  blocks.BooleanStep button(startTime = 1.25);
  {S}.InitialStep off(nIn = 0);
  {S}.Step on(nOut = 0);
  {S}.TransitionWithSignal press;
equation
  connect(button.y, press.condition);
  connect(off.outPort[1], press.inPort);
  connect(press.outPort, on.inPort[1]);
""",
        stop_time=2,
    )
    assert jumps(result, "on.active") == [(1.25, 1)]
