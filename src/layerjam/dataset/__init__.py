"""A campaign as a self-contained dataset, and the data for recomputing it."""
