"""Measurements of acausal beside reference programs, run by ``python -m benchmarks``.

Every ratio is of two things measured in turn in the same run; what a row must reach stands
beside it.
"""
