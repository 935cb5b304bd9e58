"""Steps, roots, output and restarts of IDA as native functions.

IDA takes single steps; looking for roots and interpolating is done here. IDA's own root finder
sees the interpolated algebraic unknowns, whose error nothing controls, and keeps values of the root
functions from one call to the next, which a changed shift would turn into sign changes. Here a
root function always sees points that solve the equations, and starts anew with every call.

Times in the frame: ``REACHED`` is the present point, where ``Y`` and ``YP`` are; ``END`` is the
end of IDA's last step, which may lie ahead after a root or an output.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

import numpy as np

from acausal.codegen.writer import Function, Value
from acausal.solvers.native import Word

#: Largest change of the states in the first step ever, in tolerances (as in IDA), and that step's
#: largest share of the distance to the limit. IDA's own choice, a thousandth of the distance to
#: the first output time, can be thousands of periods of a source that stands still at the start.
CHANGE, FRACTION = 0.5, 1e-6
#: First steps after restarts are chosen so that their estimated error is this many tolerances,
#: and vary by no more than these factors from one restart to the next.
FIRST_ERROR, SHRINK, GROW = 0.05, 0.1, 4.0
#: Steps too small to change the time before the run is given up.
MOST_STANDING = 50
#: Width of the interval that holds a root, in units of roundoff (as in IDA).
ROOT_WIDTH = 100.0
#: Turns of the root finder before it only bisects, and in all.
SECANTS, TURNS = 40, 150
#: Times of points that could not be settled that are remembered.
MOST_UNSETTLED = 1024
_UNIT_ROUNDOFF: Final = float(np.finfo(float).eps)
_ONE_STEP: Final = 2
_INFINITY: Final = float("inf")


class Code(IntEnum):
    """What the functions return, beside SUNDIALS' negative flags."""

    STEPPED = 0
    REACHED = 1
    ROOT = 2
    PAUSED = 3
    TOO_MANY_STEPS = -1000
    STANDING = -1001


class _Frame:
    """Words of the frame of a function under construction."""

    def __init__(self, function: Function) -> None:
        self.f = function

    def __getitem__(self, word: Word) -> Value:
        return self.f.load(self.f["frame"], int(word), "i64")

    def real(self, word: Word) -> Value:
        return self.f.load(self.f["frame"], int(word))

    def pointer(self, word: Word) -> Value:
        return self.f.load(self.f["frame"], int(word), "ptr")

    def place(self, word: Word) -> Value:
        return self.f.at(self.f["frame"], int(word))

    def set(self, word: Word, value: Value | int, kind: str = "i64") -> None:
        self.f.store(self.f["frame"], int(word), value, kind)

    def set_real(self, word: Word, value: Value | float) -> None:
        self.f.store(self.f["frame"], int(word), value)

    def call(self, word: Word, *arguments: Value) -> Value:
        return self.f.call("i32", self.pointer(word), *arguments)

    def evaluate_roots(self, t: Value, out: Word) -> None:
        """Evaluate the root functions at the point in ``Y`` and ``YP``."""
        points = (self.pointer(Word.Y), self.pointer(Word.YP))
        self.call(Word.ROOTS, t, *points, self.pointer(out), self.pointer(Word.TABLE))

    def swap(self, a: Word, b: Word) -> None:
        first, second = self.pointer(a), self.pointer(b)
        self.set(a, second, "ptr")
        self.set(b, first, "ptr")


def _crossing(f: Function, low: Value, high: Value, direction: Value) -> Value:
    """Return whether a root function has changed its sign, in a direction that is wanted."""
    rising = (low < 0.0) & (high >= 0.0) & (direction >= 0)
    falling = (low > 0.0) & (high <= 0.0) & (direction <= 0)
    finite = (f.abs(low) < _INFINITY) & (f.abs(high) < _INFINITY)
    return (rising | falling) & finite


def _worst() -> Function:
    """Return the number of the crossing function whose root is leftmost by the secant, or -1."""
    f = Function("worst", "i64", internal=True, frame="ptr", low="ptr", high="ptr")
    frame = _Frame(f)
    directions = frame.pointer(Word.DIRECTIONS)
    best, most = f.variable("i64", -1), f.variable("double", -1.0)
    with f.loop(frame[Word.ROOT_COUNT]) as k:
        low, high = f.load(f["low"], k), f.load(f["high"], k)
        with f.when(_crossing(f, low, high, f.load(directions, k, "i32"))):
            share = f.abs(high / (high - low))
            with f.when(share > most):
                most.set(share)
                best.set(k)
    f.give(best)
    return f


def _look() -> Function:
    """Put a time inside IDA's last step into ``Y`` and ``YP``; not zero if it is not inside."""
    f = Function("look", "i32", frame="ptr", t="double", y="ptr", yp="ptr")
    frame = _Frame(f)
    memory = frame.pointer(Word.MEMORY)
    flag = frame.call(Word.INTERPOLATE, memory, f["t"], f.operand(0, "i32"), f["y"])
    with f.when(flag.differs(0)):
        f.give(flag)
    frame.call(Word.INTERPOLATE, memory, f["t"], f.operand(1, "i32"), f["yp"])
    with f.when(frame[Word.CONSISTENT].differs(0) & f["t"].differs(frame.real(Word.END))):
        failed = f.call("i32", "consistent", f["frame"], f["t"], f["y"], f["yp"])
        with f.when(failed.differs(0)):
            count = frame[Word.UNSETTLED]
            with f.when(count < MOST_UNSETTLED):
                f.store(frame.pointer(Word.UNSETTLED_TIMES), count, f["t"])
            frame.set(Word.UNSETTLED, count + 1)
    f.give(0)
    return f


def _search() -> Function:
    """Look for the first root after ``low`` up to ``high``.

    ``G_LOW`` has the functions at ``low``; ``Y`` and ``YP`` are the point at ``high``. Without
    a root the result is 0 and ``G_LOW`` has the functions at ``high``. Else it is 1, and present
    point and ``FOUND`` are those of the root. The Illinois method (Dowell and Jarratt 1971) on the
    function with the leftmost secant, safeguarded as in Hiebert and Shampine (1980).
    """
    f = Function("search", "i32", internal=True, frame="ptr", low="double", high="double")
    frame = _Frame(f)
    look_at = (frame.pointer(Word.Y_VECTOR), frame.pointer(Word.YP_VECTOR))

    def worst(low: Word, high: Word) -> Value:
        return f.call("i64", "worst", f["frame"], frame.pointer(low), frame.pointer(high))

    frame.evaluate_roots(f["high"], Word.G_HIGH)
    best = f.variable("i64", worst(Word.G_LOW, Word.G_HIGH))
    with f.when(best < 0):
        frame.swap(Word.G_LOW, Word.G_HIGH)
        f.give(0)
    a, b = f.variable("double", f["low"]), f.variable("double", f["high"])
    width = (f.abs(a) + f.abs(b) + (b - a)) * (0.5 * ROOT_WIDTH * _UNIT_ROUNDOFF)
    weight, side = f.variable("double", 1.0), f.variable("i64", 0)
    there = f.variable("i64", 1)  # whether Y and YP are the point at b
    turn, on = f.variable("i64", 0), f.variable("i64", 1)
    with f.while_(lambda: on.differs(0) & (b - a > width) & (turn < TURNS)):
        turn.set(turn + 1)
        low = f.load(frame.pointer(Word.G_LOW), best)
        high = f.load(frame.pointer(Word.G_HIGH), best)
        with f.when(high.equals(0.0)):
            on.set(0)
        with f.when(high.differs(0.0)):
            secant = b - (b - a) * high / (high - weight * low)
            middle = f.variable("double", f.select(turn > SECANTS, a + 0.5 * (b - a), secant))
            # Not too near to an end of the interval, so that both ends come nearer.
            shares = (b - a) / width
            inward = f.select(shares > 5.0, f.number(0.1), 0.5 / shares) * (b - a)
            with f.when(~(f.abs(middle - a) >= 0.5 * width)):
                middle.set(a + inward)
            with f.when(~(f.abs(b - middle) >= 0.5 * width)):
                middle.set(b - inward)
            f.call("i32", "look", f["frame"], middle, *look_at)
            there.set(0)
            frame.evaluate_roots(middle, Word.G_MIDDLE)
            left = worst(Word.G_LOW, Word.G_MIDDLE)
            right = worst(Word.G_MIDDLE, Word.G_HIGH)
            before = side.read()
            with f.when(left >= 0):
                b.set(middle)
                frame.swap(Word.G_HIGH, Word.G_MIDDLE)
                there.set(1)
                best.set(left)
                weight.set(f.select(before.equals(1), weight * 0.5, 1.0))
                side.set(1)
            with f.when((left < 0) & (right >= 0)):
                a.set(middle)
                frame.swap(Word.G_LOW, Word.G_MIDDLE)
                best.set(right)
                weight.set(f.select(before.equals(2), weight * 2.0, 1.0))
                side.set(2)
            with f.when((left < 0) & (right < 0)):  # not finite in between
                on.set(0)
    with f.when(there.equals(0)):
        f.call("i32", "look", f["frame"], b, *look_at)
    lows, highs = frame.pointer(Word.G_LOW), frame.pointer(Word.G_HIGH)
    directions, found = frame.pointer(Word.DIRECTIONS), frame.pointer(Word.FOUND)
    with f.loop(frame[Word.ROOT_COUNT]) as k:
        low, high = f.load(lows, k), f.load(highs, k)
        sign = f.select(low < 0.0, f.operand(1, "i32"), -1)
        crossed = _crossing(f, low, high, f.load(directions, k, "i32"))
        f.store(found, k, f.select(crossed, sign, 0), "i32")
    frame.set_real(Word.REACHED, b)
    f.give(1)
    return f


def _choose_first_step() -> Function:
    f = Function("choose_first_step", "void", internal=True, frame="ptr", limit="double")
    frame = _Frame(f)
    t, limit = frame.real(Word.START_TIME), f["limit"]
    distance = limit - t
    step = f.variable("double", frame.real(Word.INITIAL_STEP))
    with f.when(~(step > 0.0)):
        y, yp = frame.pointer(Word.Y), frame.pointer(Word.YP)
        states, tolerance = frame.pointer(Word.STATES), frame.pointer(Word.TOLERANCE)
        relative, n = frame.real(Word.RELATIVE), frame[Word.N]
        total = f.variable("double", 0.0)
        with f.loop(n) as k, f.when(f.load(states, k) > 0.0):
            scale = relative * f.abs(f.load(y, k)) + f.load(tolerance, k)
            rate = f.load(yp, k) / scale
            total.set(total + rate * rate)
        norm = f.sqrt(total / f.real(n))
        step.set(distance * FRACTION)
        with f.when(norm * step > CHANGE):
            step.set(CHANGE / norm)
        # What was good before only makes it larger: next to a singular point the estimated
        # error of a first step says nothing, and the steps would become ever smaller.
        step.set(f.larger(frame.real(Word.START_STEP), step))
        smallest = f.larger(f.abs(t), f.abs(limit)) * (64.0 * _UNIT_ROUNDOFF)
        step.set(f.smaller(f.larger(step, smallest), distance))
    step.set(f.smaller(step, frame.real(Word.MAX_STEP)))
    frame.call(Word.SET_FIRST_STEP, frame.pointer(Word.MEMORY), step)
    return f


def _learn() -> Function:
    """Remember a good first step for the next restart: what this one's error suggests."""
    f = Function("learn", "void", internal=True, frame="ptr")
    frame = _Frame(f)
    memory = frame.pointer(Word.MEMORY)
    error, weight = frame.pointer(Word.CORRECTION_VECTOR), frame.pointer(Word.WEIGHT_VECTOR)
    frame.call(Word.GET_ERRORS, memory, error)
    frame.call(Word.GET_WEIGHTS, memory, weight)
    frame.call(Word.GET_LAST_STEP, memory, frame.place(Word.LAST_STEP))
    states = frame.pointer(Word.STATES_VECTOR)
    norm = f.variable("double", 0.0)
    suppressed = frame[Word.SUPPRESSED].differs(0)
    with f.when(suppressed):
        norm.set(f.call("double", frame.pointer(Word.MASKED_NORM), error, weight, states))
    with f.when(~suppressed):
        norm.set(f.call("double", frame.pointer(Word.NORM), error, weight))
    # At order 1 the error grows with the square of the step.
    factor = f.sqrt(FIRST_ERROR / f.larger(norm, 1e-12))
    step = frame.real(Word.LAST_STEP) * f.smaller(f.larger(factor, SHRINK), GROW)
    frame.set_real(Word.START_STEP, step)
    return f


def _take_step() -> Function:
    """Let IDA take a step from ``END``, the present point; return its flag."""
    f = Function("take_step", "i32", internal=True, frame="ptr", limit="double")
    frame = _Frame(f)
    memory = frame.pointer(Word.MEMORY)
    most = frame[Word.MOST_STEPS]
    taken = frame[Word.BASE_STEPS] + frame[Word.STEPS]
    with f.when((most >= 0) & (taken >= most)):
        f.give(int(Code.TOO_MANY_STEPS))
    fresh = frame[Word.FRESH].differs(0)
    with f.when(fresh):
        f.call("void", "choose_first_step", f["frame"], f["limit"])
    frame.call(Word.SET_STOP, memory, f["limit"])
    before = frame.real(Word.END)
    vectors = (frame.pointer(Word.Y_VECTOR), frame.pointer(Word.YP_VECTOR))
    reached, mode = frame.place(Word.REACHED), f.operand(_ONE_STEP, "i32")
    flag = frame.call(Word.SOLVE, memory, f["limit"], reached, *vectors, mode)
    frame.call(Word.STEP_COUNT, memory, frame.place(Word.STEPS))
    with f.when(flag < 0):
        frame.set_real(Word.REACHED, before)
        f.give(flag)
    now = frame.real(Word.REACHED)
    frame.set_real(Word.END, now)
    frame.set(Word.FRESH, 0)
    with f.when(fresh):
        f.call("void", "learn", f["frame"])
    standing = frame[Word.STANDING] + 1
    frame.set(Word.STANDING, f.select(now > before, f.operand(0, "i64"), standing))
    with f.when(now.equals(before) & (standing > MOST_STANDING)):
        f.give(int(Code.STANDING))
    f.give(0)
    return f


def _near(f: Function, t: Value, limit: Value) -> Value:
    """Return whether a time is too near for a first step, in IDA's opinion."""
    return limit - t <= (f.abs(t) + f.abs(limit)) * (8.0 * _UNIT_ROUNDOFF)


def _advance() -> Function:
    f = Function("advance", "i32", frame="ptr", limit="double")
    frame = _Frame(f)
    limit, present, end = f["limit"], frame.real(Word.REACHED), frame.real(Word.END)
    watching = frame[Word.ROOT_COUNT] > 0
    with f.when(watching):
        frame.evaluate_roots(present, Word.G_LOW)
    rest = end > present
    with f.when(rest):
        high = f.smaller(end, limit)
        vectors = (frame.pointer(Word.Y_VECTOR), frame.pointer(Word.YP_VECTOR))
        f.call("i32", "look", f["frame"], high, *vectors)
        frame.set_real(Word.REACHED, high)
    with f.when(~rest):
        with f.when(frame[Word.FRESH].differs(0) & _near(f, present, limit)):
            frame.set_real(Word.REACHED, limit)
            frame.set_real(Word.END, limit)
            f.give(int(Code.REACHED))
        flag = f.call("i32", "take_step", f["frame"], limit)
        with f.when(flag < 0):
            f.give(flag)
    with f.when(watching):
        found = f.call("i32", "search", f["frame"], present, frame.real(Word.REACHED))
        with f.when(found.differs(0)):
            f.give(int(Code.ROOT))
    f.give(f.select(frame.real(Word.REACHED) >= limit, f.operand(Code.REACHED, "i32"), 0))
    return f


def _output_loop() -> Function:
    """Fill output rows up to ``last``; see ``Integrator.run``.

    ``KNOWN`` is the time up to which rows may be filled: there is no root before it. Called again
    with ``begin`` 0 it goes on after a pause.
    """
    f = Function(
        "output_loop", "i32", frame="ptr", times="ptr", last="i64", out_y="ptr", out_yp="ptr",
        limit="double", begin="i64",
    )  # fmt: skip
    frame = _Frame(f)
    limit, n = f["limit"], frame[Word.N]
    watching = frame[Word.ROOT_COUNT] > 0
    vectors = (frame.pointer(Word.Y_VECTOR), frame.pointer(Word.YP_VECTOR))
    y, yp = frame.pointer(Word.Y), frame.pointer(Word.YP)
    between = (frame.pointer(Word.OUTPUT_VECTOR), frame.pointer(Word.OUTPUT_VECTOR_P))
    output, output_p = frame.pointer(Word.OUTPUT), frame.pointer(Word.OUTPUT_P)
    with f.when(f["begin"].differs(0)):
        present, end = frame.real(Word.REACHED), frame.real(Word.END)
        frame.set(Word.PENDING, 0)
        frame.set_real(Word.KNOWN, end)
        with f.when(watching):
            frame.evaluate_roots(present, Word.G_LOW)
            with f.when(end > present):
                high = f.smaller(end, limit)
                f.call("i32", "look", f["frame"], high, *vectors)
                frame.set_real(Word.REACHED, high)
                found = f.call("i32", "search", f["frame"], present, high)
                frame.set(Word.PENDING, f.select(found.differs(0), f.operand(1, "i64"), 0))
                frame.set_real(Word.KNOWN, frame.real(Word.REACHED))
    aside = f.variable("i64", 0)  # whether the last row is not the present point
    row = f.variable("i64", frame[Word.ROWS])
    time = f.variable("double", 0.0)
    with f.while_(lambda: row < f["last"]):
        time.set(f.load(f["times"], row))
        present = frame.real(Word.REACHED)
        at_start = frame[Word.FRESH].differs(0) & _near(f, present, time.read())
        ready = (time <= frame.real(Word.KNOWN)) | at_start
        with f.when(ready):
            here = time.equals(present) | at_start
            to_y, to_yp = f.at(f["out_y"], row * n), f.at(f["out_yp"], row * n)
            with f.when(here):
                f.copy(to_y, y, n)
                f.copy(to_yp, yp, n)
                aside.set(0)
            with f.when(~here):
                f.call("i32", "look", f["frame"], time, *between)
                f.copy(to_y, output, n)
                f.copy(to_yp, output_p, n)
                aside.set(1)
            row.set(row + 1)
            frame.set(Word.ROWS, row)
        with f.when(~ready):
            with f.when(frame[Word.PENDING].differs(0)):
                f.give(int(Code.ROOT))
            with f.when(frame[Word.STEPS] >= frame[Word.STEP_LIMIT]):
                f.give(int(Code.PAUSED))
            flag = f.call("i32", "take_step", f["frame"], limit)
            with f.when(flag < 0):
                f.give(flag)
            with f.when(watching):
                known = frame.real(Word.KNOWN)
                found = f.call("i32", "search", f["frame"], known, frame.real(Word.REACHED))
                frame.set(Word.PENDING, f.select(found.differs(0), f.operand(1, "i64"), 0))
            frame.set_real(Word.KNOWN, frame.real(Word.REACHED))
    with f.when(row < frame[Word.ROWS_WANTED]):
        f.give(int(Code.PAUSED))
    with f.when(frame[Word.PENDING].differs(0) & time.equals(frame.real(Word.REACHED))):
        f.give(int(Code.ROOT))
    with f.when(aside.differs(0)):
        f.copy(y, output, n)
        f.copy(yp, output_p, n)
        frame.set_real(Word.REACHED, time)
    f.give(int(Code.REACHED))
    return f


def _restart() -> Function:
    """Start IDA anew at ``t`` from ``Y`` and ``YP``."""
    f = Function("restart", "i32", frame="ptr", t="double")
    frame = _Frame(f)
    memory, n = frame.pointer(Word.MEMORY), frame[Word.N]
    frame.set(Word.BASE_STEPS, frame[Word.BASE_STEPS] + frame[Word.STEPS])
    for total, count in (
        (Word.BASE_ERROR_FAILURES, Word.GET_ERROR_FAILURES),
        (Word.BASE_CONVERGENCE_FAILURES, Word.GET_CONVERGENCE_FAILURES),
    ):
        frame.set(Word.COUNTED, 0)
        frame.call(count, memory, frame.place(Word.COUNTED))
        frame.set(total, frame[total] + frame[Word.COUNTED])
    with f.when(frame[Word.STEPS] > 0):
        frame.call(Word.GET_LAST_ORDER, memory, frame.place(Word.LAST_ORDER))
        frame.call(Word.GET_LAST_STEP, memory, frame.place(Word.LAST_STEP))
    for word in (Word.STEPS, Word.STANDING, Word.PENDING):
        frame.set(word, 0)
    frame.set(Word.FRESH, 1)
    for word in (Word.REACHED, Word.END, Word.KNOWN, Word.START_TIME):
        frame.set_real(word, f["t"])
    f.copy(frame.pointer(Word.START_Y), frame.pointer(Word.Y), n)
    f.copy(frame.pointer(Word.START_YP), frame.pointer(Word.YP), n)
    vectors = (frame.pointer(Word.Y_VECTOR), frame.pointer(Word.YP_VECTOR))
    f.give(frame.call(Word.REINITIALISE, memory, f["t"], *vectors))
    return f


def functions() -> str:
    """Return the LLVM assembly of all functions."""
    parts = (
        _worst, _look, _search, _choose_first_step, _learn, _take_step, _advance, _output_loop,
        _restart,
    )  # fmt: skip
    return "".join(part().text() for part in parts)
