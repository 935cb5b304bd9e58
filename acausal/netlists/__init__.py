"""Models made of data: graphs, chains, SPICE netlists."""
