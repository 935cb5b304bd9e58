import importlib.util
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

HAVE_ODES = any(
    importlib.util.find_spec(name) is not None for name in ("scikits_odes_sundials", "scikits")
)
needs_odes = pytest.mark.skipif(not HAVE_ODES, reason="scikits-odes is not installed")


@pytest.fixture(
    params=[
        "ida",
        pytest.param("odes-ida", marks=[pytest.mark.odes, needs_odes]),
        pytest.param("odes-cvode", marks=[pytest.mark.odes, needs_odes]),
        "radau",
    ]
)
def solver(request: pytest.FixtureRequest) -> str:
    """Return the name of each integrator in turn."""
    return request.param
