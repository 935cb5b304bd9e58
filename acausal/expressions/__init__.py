"""Symbolic expressions: construction, derivatives, evaluation, notation."""
