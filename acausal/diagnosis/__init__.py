"""Singular systems explained in terms of components, cuts and connections."""
