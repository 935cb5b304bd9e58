"""Consistent start: values of all unknowns that satisfy all equations at the first instant."""
