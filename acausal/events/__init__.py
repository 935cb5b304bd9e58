"""The discrete part of a flat model, turned into held values: parameters that change at events."""
