"""The connection graph of a model as a schematic: symbols, wires, names."""
