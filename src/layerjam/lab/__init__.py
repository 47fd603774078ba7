"""A virtual test machine and whole campaigns of it, from a stated truth."""
