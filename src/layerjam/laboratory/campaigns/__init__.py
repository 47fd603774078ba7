"""A virtual test machine, and campaigns of tests with known true values."""
