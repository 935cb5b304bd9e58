"""SPICE netlists: lines, then cards, then a model of the library's SPICE elements."""
