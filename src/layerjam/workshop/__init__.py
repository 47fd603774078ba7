"""The workshop: what to build, and the files to build it."""
