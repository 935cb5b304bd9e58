"""Elimination of alias variables, known zeros and explicit locals from a flat model."""
