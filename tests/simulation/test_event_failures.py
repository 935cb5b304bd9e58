"""Events that cannot go on: coded, with line, time and values; what came before is kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acausal import compile_file, compile_text
from tests.simulation.hybrid_runs import values

BAD = Path(__file__).parent.parent / "bad_input"


def failed(name: str) -> Any:
    result = compile_file(BAD / f"{name}.acm").simulate(stop_time=2.0)
    assert result.ending.value == "failed"
    return result


# file, code, time of the failure, what the notes and the message have to name
CASES = [
    ("relation_contradicts_itself", "E042", 1.0, ["x = 1", "t = 1 s"]),
    ("current_that_is_switched_off", "E042", 0.5, ["x = 0.5", "s = 1.5", "closed = x < 0.5"]),
    ("event_without_end", "E043", 1.0, ["on = 0, before 1", "t = 1 s"]),
    ("chattering", "E044", 1.0, ["x > 0", "noEvent", "values: x = "]),
    ("reinit_of_a_dependent_variable", "E040", np.log(2), ["pressure = 4917", "9810"]),
    ("two_reinits_contradict", "E041", np.sqrt(2 / 9.81), ["3.54356 and 0", "elsewhen"]),
    ("two_impacts_on_a_lever", "E041", 1.0, ["v1 = -1, v2 = 3"]),
    ("division_by_zero_at_an_event", "I030", 1.0, ["parts is 0", "parts = 0"]),
    ("division_by_zero_in_a_when", "I030", 1.0, ["pre(n) is 0", "pre(n) = 0"]),
    ("pole_in_finite_time", "R114", 1.0, ["log(x)", "line 5", ", x = "]),
]


@pytest.mark.parametrize(("name", "code", "time", "words"), CASES, ids=lambda c: str(c)[:30])
def test_failure_is_named_and_the_results_are_kept(
    name: str, code: str, time: float, words: list[str]
) -> None:
    result = failed(name)
    found = result.diagnostics[-1]
    assert found.code == code
    text = " ".join([found.message, found.label, *found.notes, found.help])
    for word in words:
        assert word in text, text
    assert result.times[-1] == pytest.approx(time, abs=1e-5)
    assert len(result.times) > 50
    first = result.states[0] if result.states else "x"
    assert np.all(np.isfinite(values(result, first)))
    assert found.help


def test_chattering_names_the_component() -> None:
    text = """
    model Motor
      parameter Real k = 1;
      Real w(start = 1, fixed = true);
    equation
      der(w) = if w > 0 then -k else k;
    end Motor;
    model Plant
      Motor good[2](each k = 0), bad(k = 2);
    end Plant;
    """
    result = compile_text(text).simulate(stop_time=2.0)
    (found,) = result.diagnostics
    assert found.code == "E044"
    assert found.span is not None and found.span.line == 6
    assert any("in bad" in note for note in found.notes)
    assert result.times[-1] == pytest.approx(0.5, abs=1e-6)
    assert len(result.events) <= 200


def test_many_bodies_that_change_at_nearly_one_time_do_not_chatter() -> None:
    text = """
    model Many
      parameter Integer n = 300;
      Real x[n](start = {1e-10*i for i in 1:n}, each fixed = true);
      Integer count[n];
    equation
      for i in 1:n loop
        der(x[i]) = 1;
        when x[i] > 0.5 then
          count[i] = pre(count[i]) + 1;
        end when;
      end for;
    end Many;
    """
    result = compile_text(text).simulate(stop_time=1.0, points=3)
    assert result.ending.value == "complete"
    assert sum(values(result, f"count[{i}]")[-1] for i in range(1, 301)) == 300


def test_unsolvable_start_is_told_as_one() -> None:
    text = """
    model M
      Real x(start = 1, fixed = true), y;
    equation
      der(x) = -x;
      y = if y > 0 then -1 else 1;
    end M;
    """
    from acausal.diagnostics import AcausalError

    with pytest.raises(AcausalError) as caught:
        compile_text(text).simulate(stop_time=1.0)
    assert caught.value.diagnostics[0].code == "E042"
    assert caught.value.diagnostics[0].span is not None
