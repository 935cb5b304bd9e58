"""Results: labelled trajectories, tables, files and plots."""

from acausal.results.files import read_result
from acausal.results.result import Ending, Event, Result, VariableSource
from acausal.results.trajectory import Trajectory

__all__ = ["Ending", "Event", "Result", "Trajectory", "VariableSource", "read_result"]
