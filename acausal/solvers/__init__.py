"""Integrators behind one narrow protocol."""
