"""Writes the JSON files of this folder: ``python tests/data/hybrid/make_references.py``.

Every number comes from a closed form, from matrix exponentials, or from SciPy's DOP853 at
tolerance 1e-13 with the modes written out by hand; where there are two ways the script checks
that both agree. Event records hold the values just before and just after the event.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER))

import reference_circuits as circuits  # noqa: E402
import reference_impacts as impacts  # noqa: E402
import reference_sliding as sliding  # noqa: E402

CASES = {
    "ball_on_lever": impacts.ball_on_lever,
    "ball_on_lever_level": impacts.ball_on_lever_level,
    "double_pendulum_relative_stop": lambda: impacts.double_pendulum(True),
    "double_pendulum_absolute_stop": lambda: impacts.double_pendulum(False),
    "pendulum_and_wall": impacts.pendulum_and_wall,
    "chain_on_wall": impacts.chain_on_wall,
    "falling_dumbbell": impacts.falling_dumbbell,
    "full_wave_bridge": circuits.full_wave_bridge,
    "half_wave": circuits.half_wave,
    "buck_continuous": lambda: circuits.buck(circuits.LOADS["continuous"]),
    "buck_discontinuous": lambda: circuits.buck(circuits.LOADS["discontinuous"]),
    "relay": sliding.relay,
    "sliding_mode": sliding.sliding_mode,
    "sliding_with_exit": sliding.sliding_with_exit,
    "stick_slip": sliding.stick_slip,
    "braked_block": sliding.braked_block,
}


def main() -> None:
    """Write one file per case, or those named on the command line."""
    for name in sys.argv[1:] or CASES:
        case = CASES[name]
        text = json.dumps({"case": name, **case()}, indent=1)
        (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
        print(name)


if __name__ == "__main__":
    main()
