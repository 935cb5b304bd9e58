"""Connect equations become junctions; the graph of cuts is there for people to ask."""
