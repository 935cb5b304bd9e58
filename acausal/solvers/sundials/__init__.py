"""SUNDIALS' shared libraries, found on disk and called through ctypes."""

from acausal.solvers.sundials.locate import Location, Sundials, describe, load, locations

__all__ = ["Location", "Sundials", "describe", "load", "locations"]
