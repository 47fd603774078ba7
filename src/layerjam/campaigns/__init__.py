"""A virtual test machine, and campaigns of tests with a known true brake."""
