"""provisional"""
from __future__ import annotations
import numpy as np
class StateSelector:
    def __init__(self, system):
        self.system=system; self.has_alternatives=False
    def first(self, values, time):
        assert not self.system.offsets.c.any()
        return np.flatnonzero((self.system.derivative>=0)&self.system.active)
    def better(self, values, time, force=False): return None
