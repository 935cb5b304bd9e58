"""Drivers on a bus, multiplexer, registers and memories of nine-valued logic."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from tests.library.electrical.circuits import run, values

LITERALS = "UX01ZWLH-"
# the table of IEEE standard 1164, rows and columns in the order above
RESOLVED = (
    "UUUUUUUUU UXXXXXXXX UX0X0000X UXX11111X UX01ZWLHX UX01WWWWX UX01LWLWX UX01HWWHX UXXXXXXXX"
)


def logic(letters: str) -> str:
    return "{" + ", ".join(f"electrical.digital.Logic.'{c}'" for c in letters) + "}"


def table(name: str, letters: str) -> str:
    """Return a source that goes to the next value every second, from t = 1 on."""
    times = "{" + ", ".join(str(k) for k in range(1, len(letters))) + "}"
    return (
        f"  electrical.digital.Table {name}(y0 = electrical.digital.Logic.'{letters[0]}', "
        f"x = {logic(letters[1:])}, t = {times});\n"
    )


def sampled(result: Any, path: str, count: int) -> str:
    """Return the values in the middle of each second as letters."""
    at = np.searchsorted(result.times, np.arange(count) + 0.5)
    return "".join(LITERALS[int(k) - 1] for k in values(result, path)[at])


def drive(body: str, equations: str, seconds: int, **sources: str) -> Any:
    text = "  import electrical.digital.*;\n" + "".join(table(k, v) for k, v in sources.items())
    return run(f"{text}{body}equation\n{equations}", seconds, points=20 * seconds + 1)


def test_wired_outputs() -> None:
    pairs = list(itertools.product(LITERALS, LITERALS))
    result = drive(
        "  WiredX wire(n = 2);\n",
        "  connect(a.y, wire.x[1]);\n  connect(b.y, wire.x[2]);\n",
        81,
        a="".join(p[0] for p in pairs),
        b="".join(p[1] for p in pairs),
    )
    assert sampled(result, "wire.y", 81) == RESOLVED.replace(" ", "")


@pytest.mark.parametrize(
    ("gate", "expected"),
    [
        ("BUF3S", "Z01Z01XUX0"),
        ("BUF3SL", "0ZZ1ZZXUZZ"),
        ("INV3S", "Z10Z10XUX1"),
        ("INV3SL", "1ZZ0ZZXUZZ"),
        ("NXFERGATE", "Z0HZL1XUZ0"),
        ("PXFERGATE", "0ZZ1ZZXUZZ"),
    ],
)
def test_drivers_that_can_be_cut_off(gate: str, expected: str) -> None:
    data, enable = "00H1L111Z0", "011011XU1H"
    result = drive(
        f"  {gate} gate(enable = e.y);\n", "  connect(d.y, gate.x);\n", 10, d=data, e=enable
    )
    assert sampled(result, "gate.y", 10) == expected


def test_buffer_with_a_delay_and_multiplexer() -> None:
    result = drive(
        "  BufGate gate(tLH = 0.25, tHL = 0.1);\n  MUX2x1 mux;\n",
        "  connect(d.y, gate.x, mux.in0);\n  connect(e.y, mux.in1);\n  connect(s.y, mux.sel);\n",
        6,
        d="0H0H11",
        e="111001",
        s="001XXX",
    )
    assert sampled(result, "gate.y", 6)[1:] == "10111"
    changes = result.times[np.flatnonzero(np.diff(values(result, "gate.y"))) + 1]
    assert changes[-3:] == pytest.approx([1.25, 2.1, 3.25])
    assert sampled(result, "mux.out", 6) == "011XX1"


STORES = "  connect(d.y, store.dataIn[1]);\n  connect(r.y, store.reset);\n"


@pytest.mark.parametrize(
    ("store", "reset"),
    [
        ("DLATREG store(n = 1)", "1000000001"),
        ("DLATR store(y0 = Logic.'U')", "1000000001"),
        ("DLATREGL store(n = 1)", "0111111110"),
    ],
)
def test_latches(store: str, reset: str) -> None:
    data, enable = "1011001011", "0111001011"
    result = drive(
        f"  {store};\n",
        STORES + "  connect(e.y, store.enable);\n",
        10,
        d=data,
        e=enable,
        r=reset,
    )
    kept, wanted = "0", ""
    for k in range(10):
        active = reset[k] == ("0" if "DLATREGL" in store else "1")
        kept = "0" if active else data[k] if enable[k] == "1" else kept
        wanted += kept
    assert sampled(result, "store.dataOut[1]", 10) == wanted
    assert "1" in wanted and "0" in wanted[1:-1]


@pytest.mark.parametrize(
    ("store", "reset"),
    [
        ("DFFREG store(n = 2, tLH = 0.1)", "1000000001"),
        ("DFFR store(y0 = Logic.'U')", "1000000001"),
        ("DFFREGL store(n = 1)", "0111111110"),
    ],
)
def test_flip_flops(store: str, reset: str) -> None:
    data, clock = "1101010110", "0110010101"
    more = "  connect(d.y, store.dataIn[2]);\n" if "n = 2" in store else ""
    result = drive(
        f"  {store};\n",
        STORES + more + "  connect(c.y, store.clock);\n",
        10,
        d=data,
        c=clock,
        r=reset,
    )
    kept, wanted = "0", ""
    for k in range(10):
        active = reset[k] == ("0" if "DFFREGL" in store else "1")
        rises = k > 0 and clock[k] == "1" and clock[k - 1] == "0"
        kept = "0" if active else data[k] if rises else kept
        wanted += kept
    assert sampled(result, "store.dataOut[1]", 10) == wanted
    assert wanted.count("1") > 2


def test_memories() -> None:
    result = drive(
        """  DLATRAM ram(n_addr = 2, n_data = 2);
  DLATROM rom(n_addr = 2, n_data = 3, mem = {MEMORY});
""".replace("MEMORY", ", ".join(logic(row) for row in ("001", "010", "111", "1XH"))),
        """  connect(a.y, ram.addr[1], rom.addr[1]);
  connect(b.y, ram.addr[2], rom.addr[2]);
  connect(w.y, ram.WE);
  connect(r.y, ram.RE, rom.RE);
  connect(d.y, ram.dataIn[1]);
  connect(e.y, ram.dataIn[2]);
""",
        9,
        a="010101X10",
        b="001101010",
        w="011100000",
        r="000011101",
        d="010100000",
        e="011000000",
    )
    # written: address 1 <- (1, 1), 2 <- (0, 1), 3 <- (1, 0); address 0 never
    assert sampled(result, "ram.dataOut[1]", 9) == "ZZZZU1XZU"
    assert sampled(result, "ram.dataOut[2]", 9) == "ZZZZU0XZU"
    assert sampled(result, "rom.dataOut[1]", 9) == "ZZZZ01XZ0"
    assert sampled(result, "rom.dataOut[3]", 9) == "ZZZZ1HXZ1"
