"""Analysis of time logs: pressure, acceleration, vacuum."""
