"""A campaign as a self-contained dataset, and the data needed to recompute it."""
