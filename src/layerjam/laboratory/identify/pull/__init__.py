"""Analysis of one measured pull."""
