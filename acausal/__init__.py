"""Acausal multiport modelling and simulation."""
