"""What ``acausal --version`` says."""

from __future__ import annotations

import platform

from acausal.version import __version__


def versions() -> str:
    """Return the version of acausal, of Python, and the SUNDIALS that is used."""
    from acausal.solvers.sundials.locate import describe

    return f"acausal {__version__}\n{describe()}\nPython {platform.python_version()}"
