"""Simulates a Modelica file with rumoca and writes a CSV file: FILE MODEL STOP POINTS OUTPUT."""

from __future__ import annotations

import sys


def main() -> None:
    """Read, compile, simulate, write."""
    import rumoca

    file, model, stop, points, output = sys.argv[1:]
    result = (
        rumoca.Session()
        .load(file, model=model)
        .simulate(
            (0.0, float(stop)),
            dt=float(stop) / (int(points) - 1),
            config=rumoca.SimConfig(rtol=1e-6, atol=1e-9),
        )
    )
    columns = [result.time, *result.to_numpy()]
    with open(output, "w", encoding="utf-8") as stream:
        stream.write(",".join(["time", *result.names]) + "\n")
        for row in zip(*(c.tolist() for c in columns), strict=True):
            stream.write(",".join(map(repr, row)) + "\n")


if __name__ == "__main__":
    main()
