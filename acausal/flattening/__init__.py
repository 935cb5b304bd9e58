"""Instances to one flat system of equation families."""
