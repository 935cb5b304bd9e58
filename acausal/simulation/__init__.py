"""Integration over segments between time events and changes of states."""
