"""Sources controlled by a polynomial: ``POLY(1)``."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from acausal.compose.component import ComponentType
from acausal.compose.declarations import Parameter
from acausal.netlists.packages import package


@cache
def polynomial_class(letter: str, count: int) -> Any:
    """Return the class of sources with so many coefficients.

    Args:
        letter: E, F, G or H.
        count: Number of coefficients, the constant one first.
    """
    electrical = package("electrical")

    def equations(self: Any) -> Iterator[Any]:
        control, output = (
            self.v1 if letter in "EG" else self.i1,
            self.v2 if letter in "EH" else self.i2,
        )
        value = self.c[count - 1]
        for k in reversed(range(count - 1)):  # Horner's scheme
            value = self.c[k] + control * value
        yield output == value
        yield (self.i1 if letter in "EG" else self.v1) == 0

    about = {"E": "voltage of a voltage", "F": "current of a current", "G": "current of a voltage",
             "H": "voltage of a current"}[letter]  # fmt: skip
    coefficients = Parameter(
        [0.0] * count, shape=count, description="coefficients, the constant one first"
    )
    return ComponentType(
        f"{letter}_POLY",
        (electrical.TwoPort,),
        {
            "__module__": "acausal_netlist",
            "__doc__": f"Polynomial source: {about}",
            "c": coefficients,
            "equations": equations,
        },
    )
