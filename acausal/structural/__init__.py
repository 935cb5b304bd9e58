"""Structural analysis on integers: matching, index reduction, states, blocks, tearing.

Every pass sees rows, variable ids and orders of derivatives, never expressions; templates are only
touched by :mod:`acausal.structural.differentiate`, once per family. Nothing recurses, everything
is deterministic, and the passes a large system goes through are about ``O(n log n)``.
"""
