"""A campaign as a dataset that stands alone, and what recomputing it needs."""
