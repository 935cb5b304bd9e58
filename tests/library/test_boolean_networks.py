"""Random networks of gates, delays of one iteration and counters against a direct evaluation."""

from __future__ import annotations

import random

import pytest

from tests.library.blocks_runs import jumps, run, values

GATES = {
    "And": lambda a, b: a and b,
    "Or": lambda a, b: a or b,
    "Xor": lambda a, b: a != b,
    "Nand": lambda a, b: not (a and b),
    "Nor": lambda a, b: not (a or b),
}


class Network:
    """Sources, then blocks that only refer to earlier ones.

    Attributes:
        sources: Times at which each source changes.
        blocks: Kind and the numbers of the inputs; sources come first in the numbering.
    """

    def __init__(self, seed: int) -> None:
        choose = random.Random(seed)
        self.sources = [sorted(choose.sample(range(1, 20), choose.randint(1, 8))) for _ in range(3)]
        self.blocks: list[tuple[str, tuple[int, ...]]] = []
        for k in range(14):
            kind = choose.choice([*GATES, *GATES, "Pre", "Pre", "Edge", "Change", "Not"])
            last = len(self.sources) + k
            inputs = tuple(choose.randrange(last) for _ in range(2 if kind in GATES else 1))
            self.blocks.append((kind, inputs))

    def name(self, number: int) -> str:
        """Return the path of a signal."""
        n = len(self.sources)
        return f"source{number}.y" if number < n else f"block{number - n}.y"

    def text(self) -> str:
        """Return the body of the model: every signal is counted, too."""
        lines = ["  blocks.IntegerConstant one;"]
        for k, times in enumerate(self.sources):
            table = ", ".join(map(str, times))
            lines.append(f"  blocks.BooleanTable source{k}(table = {{{table}}});")
        for k, (kind, _) in enumerate(self.blocks):
            lines.append(f"  blocks.{kind} block{k};")
        total = len(self.sources) + len(self.blocks)
        lines.append(f"  blocks.math_integer.TriggeredAdd count[{total}];")
        lines.append("equation")
        for k, (_, inputs) in enumerate(self.blocks):
            for i, number in enumerate(inputs):
                port = f"u{i + 1}" if len(inputs) == 2 else "u"
                lines.append(f"  connect({self.name(number)}, block{k}.{port});")
        for k in range(total):
            lines.append(f"  connect({self.name(k)}, count[{k + 1}].trigger);")
            lines.append(f"  connect(one.y, count[{k + 1}].u);")
        return "\n".join(lines)

    def evaluate(self, time: float, pre: list[bool]) -> list[bool]:
        """Return all signals for frozen values before the event."""
        now = [sum(t <= time for t in times) % 2 == 1 for times in self.sources]
        for kind, inputs in self.blocks:
            u = [now[i] for i in inputs]
            if kind in GATES:
                now.append(GATES[kind](*u))
            elif kind == "Not":
                now.append(not u[0])
            elif kind == "Pre":
                now.append(pre[inputs[0]])
            elif kind == "Edge":
                now.append(u[0] and not pre[inputs[0]])
            else:
                now.append(u[0] != pre[inputs[0]])
        return now

    def expected(self) -> tuple[list[bool], list[int]]:
        """Return signals and counters at the end."""
        total = len(self.sources) + len(self.blocks)
        # What a block says about the value before the start counts; others begin as they are.
        pre = [False] * total
        counters = [0] * total
        started = False
        for time in range(21):
            for _ in range(50):
                now = self.evaluate(time, pre)
                if started:
                    for k in range(total):
                        counters[k] += now[k] and not pre[k]
                if now == pre:
                    break
                pre = now
                started = True
            started = True
        return pre, counters


@pytest.mark.parametrize("seed", range(12))
def test_network(seed: int) -> None:
    network = Network(seed)
    result = run(network.text(), stop_time=20.5)
    signals, counters = network.expected()
    for k, signal in enumerate(signals):
        assert values(result, network.name(k))[-1] == signal, network.name(k)
    assert sum(counters) > 20
    found = [values(result, f"count[{k + 1}].y")[-1] for k in range(len(counters))]
    # At the start no edge is seen where nothing is said about the value before.
    assert found == counters
    assert all(t == round(t) for k in range(3) for t, _ in jumps(result, network.name(k)))
